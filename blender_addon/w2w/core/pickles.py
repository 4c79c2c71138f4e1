# SPDX-License-Identifier: GPL-3.0-or-later
"""Pickles of models and of motions opened without trust: arrays are built, everything else is refused."""

import os
import zlib
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path
from typing import IO, Any
from zipfile import ZipFile, is_zipfile

import numpy as np

from .files import DAMAGED, MOST_BYTES, as_array, most_unpacked, read_arrays as read_plain_arrays, read_header
from .stand_ins import Storage, plain, stand_in
from .unpickler import DAMAGED_PICKLE, RefusedPickleError, Unpickler
from .wording import restated

PACKED = (b"\x78", b"\x1f\x8b")
MOST_RESULT_BYTES = 2 * 2**30


def read_result(path: str | Path) -> Any:
    """Content of a pkl (also joblib's, packed or not) or pt file: containers, numbers, text and arrays.

    Raises RefusedPickleError if it is neither, is damaged, or names anything but these.
    """
    with restated(DAMAGED_PICKLE, (StopIteration, *DAMAGED), RefusedPickleError):
        if is_zipfile(path):
            return _read_torch(path)
        data = Path(path).read_bytes()
        if data.startswith(PACKED):
            unpacker = zlib.decompressobj(wbits=47)  # zlib or gzip
            data = unpacker.decompress(data, min(MOST_RESULT_BYTES, most_unpacked(len(data))))
            if unpacker.unconsumed_tail:
                raise RefusedPickleError("it unpacks to more than any motion needs")
        return Unpickler(data, stand_in).load()


def _read_torch(path: str | Path) -> Any:
    """Read what torch.save wrote: a zip of a pickle, and one file per storage."""
    with ZipFile(path) as archive:
        size = sum(member.file_size for member in archive.infolist())
        if size > min(MOST_RESULT_BYTES, most_unpacked(Path(path).stat().st_size)):
            raise RefusedPickleError("it unpacks to more than any motion needs")
        pickled = next(name for name in archive.namelist() if name.endswith("data.pkl"))
        kept: dict[str, np.ndarray] = {}

        def storage(pid: Any) -> np.ndarray:
            _, kind, key, *_ = pid
            if not isinstance(kind, Storage) or not isinstance(key, str) or not key.isalnum():
                raise RefusedPickleError("it refers to something that is no array")
            if key not in kept:
                data = archive.read(f"{pickled.removesuffix('data.pkl')}data/{key}")
                kept[key] = as_array(data, (len(data) // kind.dtype.itemsize,), kind.dtype, "C")
            return kept[key]

        return Unpickler(archive.read(pickled), stand_in, storage, size).load()


def read_arrays(path: Path, wanted: Collection[str]) -> dict[str, Any]:
    """Contents of a pickled model by name; those `wanted` as ndarrays, from numpy, scipy.sparse or chumpy.

    Raises RefusedPickleError if it is no pickled dict, is damaged, or names anything but arrays.
    """
    with path.open("rb") as stream:
        content = _load(stream, path.stat().st_size)
    if not isinstance(content, dict):
        raise RefusedPickleError(f"it holds a {type(content).__name__}, not a model's named arrays")
    return {str(name): plain(value) if name in wanted else value for name, value in content.items()}


def read_npz_member(path: str | Path, name: str) -> np.ndarray:
    """One array of an npz; an object array is opened as warily as a pickled model.

    Raises RefusedPickleError if the array is a pickle that names anything but arrays.
    """
    # of a damaged file the plain reader says what is wrong
    with suppress(*DAMAGED), ZipFile(path) as archive, archive.open(f"{name}.npy") as stream:
        _, _, dtype = read_header(stream)
        size, held = archive.getinfo(f"{name}.npy").file_size, archive.fp
        if dtype.hasobject and size > most_unpacked(held.seek(0, os.SEEK_END) if held else 0):
            raise RefusedPickleError(f"it would unpack to {size / 2**30:.1f} GiB, which no model does")
        if dtype.hasobject:
            return plain(_only(_load(stream, size)))
    return read_plain_arrays(path, (name,), MOST_BYTES)[name]


def read_npy_object(path: str | Path) -> Any:
    """The pickled content of an npy file, opened with the same care; None if it holds numbers or is damaged.

    Raises RefusedPickleError if it names anything but arrays.
    """
    with Path(path).open("rb") as stream:
        try:
            _, _, dtype = read_header(stream)
        except (ValueError, *DAMAGED):
            return None  # the plain reader says what is wrong
        return _only(_load(stream, Path(path).stat().st_size)) if dtype.hasobject else None


def _load(stream: IO[bytes], size: int) -> Any:
    if size > MOST_RESULT_BYTES:
        raise RefusedPickleError("it is larger than any model or motion")
    return Unpickler(stream.read(), stand_in).load()


def _only(content: Any) -> Any:
    """The only one of some objects, or them all."""
    return content[0] if isinstance(content, list) and len(content) == 1 else content
