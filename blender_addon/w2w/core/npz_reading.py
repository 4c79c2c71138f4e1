# SPDX-License-Identifier: GPL-3.0-or-later
"""Read npz files from anywhere: no pickles, no more memory than the file honestly holds, only ValueErrors."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Collection
from pathlib import Path
from tokenize import TokenError
from typing import BinaryIO
from zipfile import BadZipFile, ZipFile, is_zipfile

import numpy as np
from numpy.lib import format as npy

DAMAGED = (
    BadZipFile,
    EOFError,
    KeyError,
    MemoryError,
    NotImplementedError,  # a compression that Python lacks
    OverflowError,
    RuntimeError,  # a password
    SyntaxError,
    TokenError,
    TypeError,
    UnicodeError,
    struct.error,
    zlib.error,
)
"""What Python's zip and numpy's npy reading raise on damaged files, beside ValueError and OSError."""

MAX_CHARACTER = 0x10FFFF

PLAIN = "biufU"
"""Kinds of numbers and text; dates, structures, complex numbers and objects are none of W2W's."""


def array_names(path: str | Path) -> list[str]:
    """Names of the arrays in an npz file.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is no npz file.
    """
    try:
        with ZipFile(path) as archive:
            return [name.removesuffix(".npy") for name in archive.namelist() if name.endswith(".npy")]
    except DAMAGED as error:
        raise ValueError(f"it cannot be read as an npz file: {_fault(path, error)}") from error


def read_arrays(path: str | Path, names: Collection[str], most_bytes: int) -> dict[str, np.ndarray]:
    """Read arrays of an npz file, those of them that it holds.

    Parameters
    ----------
    path : str or Path
    names : collection of str
        The arrays wanted; others are not even unpacked.
    most_bytes : int
        That the arrays may take together; a small file may claim to unpack to far more.

    Returns
    -------
    dict of str to ndarray
        Numbers and text only.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is damaged, holds other things than numbers and text, or unpacks to too much.
    """
    try:
        with ZipFile(path) as archive:
            members = {name: f"{name}.npy" for name in names if f"{name}.npy" in archive.NameToInfo}
            size = sum(archive.getinfo(member).file_size for member in members.values())
            if size > most_bytes:
                raise ValueError(f"it would unpack to {size / 2**30:.1f} GiB, more than any motion needs")
            arrays = {}
            for name, member in members.items():
                try:
                    arrays[name] = _read_member(archive, member)
                except ValueError as error:  # numpy's own words quote bytes
                    raise ValueError(f"its '{name}' is damaged or holds neither numbers nor text") from error
            return arrays
    except DAMAGED as error:
        raise ValueError(f"it cannot be read as an npz file: {_fault(path, error)}") from error


def _read_member(archive: ZipFile, member: str) -> np.ndarray:
    with archive.open(member) as stream:
        shape, _, dtype = read_header(stream)
    held = archive.getinfo(member).file_size
    if dtype.kind not in PLAIN or math.prod(shape) * dtype.itemsize > held:
        raise ValueError(member)
    with archive.open(member) as stream:
        array = npy.read_array(stream, allow_pickle=False)
    if dtype.kind == "U" and not _is_text(array):
        raise ValueError(member)
    return array


def _fault(path: str | Path, error: Exception) -> str:
    """What is wrong with the archive, without the bytes that zipfile quotes."""
    if isinstance(error, MemoryError):
        return "it takes more memory than there is"
    if isinstance(error, NotImplementedError):
        return "it is packed in a way that Python does not know; save it again with numpy.savez_compressed"
    if isinstance(error, RuntimeError):
        return "it is locked with a password"
    return "it is damaged" if is_zipfile(path) else "it is no zip archive, which an npz file is"


def _is_text(array: np.ndarray) -> bool:
    """Whether all characters exist: Python fails on others with an error of its own insides."""
    letters = (
        np.ascontiguousarray(array).reshape(-1).view(np.dtype(np.uint32).newbyteorder(array.dtype.byteorder))
    )
    return bool((letters <= MAX_CHARACTER).all())


def read_header(stream: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Shape, whether the order is Fortran's, and dtype of an npy stream, left at the first value."""
    version = npy.read_magic(stream)
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    return read(stream)
