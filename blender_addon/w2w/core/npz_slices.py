# SPDX-License-Identifier: GPL-3.0-or-later
"""Read part of an array of an uncompressed npz file without reading the rest."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from pathlib import Path
from zipfile import ZIP_STORED, ZipFile

import numpy as np

from .npz_reading import DAMAGED, read_header

LOCAL_HEADER = struct.Struct("<26x2H")
"""Of a zip member: the lengths of its name and of its extra field stand after 26 bytes."""


@dataclass(frozen=True)
class StoredArray:
    """Where an array (W, N, ...) of single precision stands in a file.

    Parameters
    ----------
    path : Path
    offset : int
        Byte of its first value.
    shape : tuple of int
    dtype : dtype
    """

    path: Path
    offset: int
    shape: tuple[int, ...]
    dtype: np.dtype

    @classmethod
    def find(cls, path: Path, name: str) -> StoredArray:
        """Find an array that `files.write_npz` wrote.

        Raises
        ------
        OSError
            If the file is not there.
        ValueError
            If it holds no such array, or compresses it.
        """
        try:
            with ZipFile(path) as archive:
                info = archive.getinfo(f"{name}.npy")
                if info.compress_type != ZIP_STORED:
                    raise ValueError(f"{path}: '{name}' is compressed and cannot be read in parts")
                with path.open("rb") as stream:
                    stream.seek(info.header_offset)
                    stream.seek(sum(LOCAL_HEADER.unpack(stream.read(LOCAL_HEADER.size))), 1)
                    shape, is_fortran, dtype = read_header(stream)
                    offset = stream.tell()
        except DAMAGED as error:
            raise ValueError(f"{path} does not hold the array '{name}'") from error
        held = offset + math.prod(shape) * dtype.itemsize <= path.stat().st_size
        if is_fortran or dtype != np.float32 or len(shape) != 3 or 0 in shape or not held:
            raise ValueError(f"{path}: '{name}' is not an array that W2W wrote")
        return cls(path, offset, shape, dtype)

    def columns(self, first: int, last: int) -> np.ndarray:
        """The part from `first` to before `last` of the second axis, as a copy.

        The file is mapped for the moment of the copy only, so that its pages do not count
        as this process's memory.
        """
        whole = np.memmap(self.path, self.dtype, "r", self.offset, self.shape)
        return np.array(whole[:, first:last])
