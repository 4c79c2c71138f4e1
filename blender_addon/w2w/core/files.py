# SPDX-License-Identifier: GPL-3.0-or-later
"""Read npz files from anywhere: no pickles, no more memory than the file honestly holds, only ValueErrors."""

import hashlib
import io
import json
import math
import os
import struct
import tempfile
import zlib
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from errno import EISDIR, ENOENT
from functools import lru_cache
from pathlib import Path
from tokenize import TokenError
from typing import IO, Any, BinaryIO, Literal
from zipfile import ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo, is_zipfile

import numpy as np
from numpy.lib import format as npy

from .given import given_path
from .wording import restated

MOST_BYTES = 16 * 2**30
"""No file of W2W unpacks to more."""

UNPACKED_FREELY, MOST_UNPACKED = 2**26, 50
"""Bytes that any file may unpack to, and how many times its size a larger one may: numbers that were measured
pack to a half or a tenth."""

MOST_HEADER = 10_000
"""Bytes of an npy header, as NumPy has it; a longer one is not even read."""

ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)
"""Time stamp of every member of an npz, so that equal arrays give equal bytes."""

DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))}
"""Names that Windows keeps for devices, in lower case: no file can have one, with any ending."""

UNFINISHED = ".w2w.part"
"""Suffix of half-written files, which nobody else uses."""

DIGITS = 6
"""Decimals of scores on file."""


_told: ContextVar[tuple[Callable[[Path, Path], None], ...]] = ContextVar("told", default=())


@contextmanager
def told_of_writes(tell: Callable[[Path, Path], None]) -> Iterator[None]:
    """Call `tell` with the temporary file and the path to which `atomic_write` is about to rename it."""
    before = _told.set((*_told.get(), tell))
    try:
        yield
    finally:
        _told.reset(before)


@contextmanager
def atomic_write(path: str | Path) -> Iterator[BinaryIO]:
    """Open a temporary file next to `path`, in binary mode, and rename it to `path` when all went well.

    A kill leaves the old or the new. So that a clip does not wait for the disk, this does not: after a power
    cut the new may be short, which its size, hash or checksum tells. `told_of_writes` may wait.
    """
    path = given_path(path, "a file to write")
    if not path.parent.is_dir():
        raise FileNotFoundError(ENOENT, "There is no such folder", str(path.parent))
    if path.is_dir():
        raise IsADirectoryError(EISDIR, "It is a folder", str(path))
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:40]}.", suffix=UNFINISHED)
    try:
        mask = os.umask(0)  # the only way to read it
        os.umask(mask)
        Path(temporary).chmod(0o666 & ~mask)
        with os.fdopen(handle, "wb") as stream:
            yield stream
        for tell in _told.get():
            tell(Path(temporary), path)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def folder_beside(path: Path) -> tempfile.TemporaryDirectory[str]:
    """A temporary folder next to a path, so that its content gets its final name by a rename."""
    return tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.stem[:40]}.", suffix=UNFINISHED)


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """Give the block a place for a folder, which takes the folder's once the block is done."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with folder_beside(folder) as temporary:
        yield (made := Path(temporary, folder.name))
        if folder.exists():
            folder.rmdir()
        made.replace(folder)


def write_npz(path: str | Path, arrays: Mapping[str, Any], compress: bool = False) -> None:
    """Write arrays, but none of objects, to an npz file, atomically and with reproducible bytes."""
    method = ZIP_DEFLATED if compress else ZIP_STORED
    with atomic_write(path) as stream, ZipFile(stream, "w", method) as archive:
        for name, value in arrays.items():
            array, header, info = np.asanyarray(value), io.BytesIO(), ZipInfo(f"{name}.npy", ZIP_EPOCH)
            if array.dtype.hasobject:
                raise ValueError(f"Object arrays, such as '{name}', are not written")
            about = npy.header_data_from_array_1_0(array)
            npy.write_array_header_1_0(header, about)
            info.compress_type, info.file_size = method, header.tell() + array.nbytes
            with archive.open(info, "w") as stored:  # by numpy it takes copies
                stored.write(header.getvalue())
                stored.write(np.ascontiguousarray(array.T if about["fortran_order"] else array).data)


def write_json(path: str | Path, content: Any) -> None:
    """Write indented UTF-8 JSON atomically; refuses NaN and infinities."""
    write_text(path, json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def json_number(value: float) -> float | None:
    """A score for JSON: rounded, and null if it is not known."""
    return None if np.isnan(value) else round(float(value), DIGITS)


def write_text(path: str | Path, text: str) -> None:
    r"""Write UTF-8 text atomically, with the line ends that `text` has.

    Characters that are no Unicode are written as ``\udce9``: one odd file name must not cost a whole result.
    """
    with atomic_write(path) as stream:
        stream.write(text.encode("utf-8", "backslashreplace"))


def reserved(name: str) -> bool:
    """Whether Windows would take a file name for a device, as it does ``aux.npz``."""
    return name.split(".")[0].strip().lower() in DEVICES


def file_sha256(path: str | Path) -> str:
    """SHA-256 of a file's bytes, in hexadecimal."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def stamp(path: Path) -> list[int]:
    """Size, times (ns), inode and device of a file, where links lead: another file has another stamp."""
    try:
        found = os.stat(path)  # noqa: PTH116 - a path's own call costs more
    except OSError:
        return []
    return [found.st_size, found.st_mtime_ns, found.st_ctime_ns, found.st_ino, found.st_dev]


DAMAGED = (
    BadZipFile, EOFError, KeyError, MemoryError, OverflowError, SyntaxError, TokenError, TypeError,
    RuntimeError,  # a password, or (NotImplementedError) a compression that Python lacks
    UnicodeError, struct.error, zlib.error,
)  # fmt: skip
"""Errors of Python's zip and numpy's npy reading on damaged files, besides ValueError and OSError."""

MAX_CHARACTER = 0x10FFFF

PIECE = 2**18
"""Bytes that are unpacked at once: reading a zip's member takes as many again."""

PLAIN = "biufU"
"""Kinds of numbers and text; W2W writes no dates, structures, complex numbers or objects."""


def array_names(path: str | Path) -> list[str]:
    """Names of the arrays in an npz file; OSError or ValueError if it cannot be read."""
    try:
        with ZipFile(path) as archive:
            return [name.removesuffix(".npy") for name in archive.namelist() if name.endswith(".npy")]
    except DAMAGED as error:
        raise ValueError(f"it cannot be read as an npz file: {_fault(path, error)}") from error


def most_unpacked(size: int) -> int:
    """Bytes that a file or text of `size` bytes may unpack to."""
    return max(UNPACKED_FREELY, MOST_UNPACKED * size)


Check = Callable[[tuple[int, ...]], None]
"""A check that raises if no array of such a shape is acceptable."""


def read_arrays(
    path: str | Path, names: Collection[str], most_bytes: int, check: Check | None = None
) -> dict[str, np.ndarray]:
    """Read those of some arrays that an npz file holds; others are not even unpacked.

    `check` is given the shape of each before any is unpacked.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is damaged, holds other things than numbers and text, or claims to unpack to more than
        `most_bytes` or `most_unpacked`.
    """
    try:
        with ZipFile(path) as archive:
            members = {name: f"{name}.npy" for name in names if f"{name}.npy" in archive.NameToInfo}
            for name, member in members.items():
                if check is not None:
                    with _described(name), archive.open(member) as stream:
                        shape = read_header(stream)[0]
                    check(shape)
            size, held = sum(archive.getinfo(member).file_size for member in members.values()), archive.fp
            if size > min(most_bytes, most_unpacked(held.seek(0, os.SEEK_END) if held else 0)):
                raise ValueError(f"it would unpack to {size / 2**30:.1f} GiB, more than any motion needs")
            arrays = {}
            for name, member in members.items():
                with _described(name), archive.open(member) as stream:
                    arrays[name] = _read_values(stream, archive.getinfo(member).file_size)
            return arrays
    except DAMAGED as error:
        raise ValueError(f"it cannot be read as an npz file: {_fault(path, error)}") from error


@contextmanager
def _described(name: str) -> Iterator[None]:
    """Name the damaged array if the block raises a ValueError: NumPy's own message quotes bytes."""
    with restated(f"its '{name}' is damaged or holds neither numbers nor text", ValueError):
        yield


def load_arrays(
    path: str | Path, needed: Collection[str], wrong: str, optional: Collection[str] = ()
) -> dict[str, np.ndarray]:
    """Read needed and optional arrays of a file that W2W wrote.

    Raises ValueError, with the file and what is `wrong`, such as "is not a W2W body", if it is damaged or
    lacks a needed array.
    """
    with restated(f"{path} {wrong}:", ValueError):
        arrays = read_arrays(path, (*needed, *optional), MOST_BYTES)
    if missing := sorted(set(needed) - arrays.keys()):
        raise ValueError(f"{path} {wrong}: it lacks {', '.join(missing)}")
    return arrays


def read_npy(path: Path, check: Check | None = None) -> np.ndarray:
    """Read an npy file of numbers or text; ValueError, with the file's name, if it is none or damaged.

    `check` is given the shape before the values are read.
    """
    damaged = f"{path} is damaged or no npy file of numbers or text"  # numpy's own words quote bytes
    with restated(damaged, (ValueError, *DAMAGED)), path.open("rb") as stream:
        if check is not None:
            check(read_header(stream)[0])
            stream.seek(0)
        return _read_values(stream, path.stat().st_size)


def npy_shape(path: Path) -> tuple[int, ...]:
    """Shape of an npy file's array by its header; () if it cannot be read."""
    with suppress(ValueError, OSError, *DAMAGED):
        if path.is_file():
            with path.open("rb") as stream:
                return read_header(stream)[0]
    return ()


def _read_values(stream: IO[bytes], held: int) -> np.ndarray:
    """The array of an npy stream that holds `held` bytes, independent of what its header claims.

    Parses the header once; numpy's own `read_array` would have to do so again.
    """
    shape, is_fortran, dtype = read_header(stream)
    size = math.prod(shape) * dtype.itemsize
    if dtype.kind not in PLAIN or max(size, math.prod(shape)) > held:
        raise ValueError("it claims more than it holds, or other things than numbers and text")
    data = np.empty(size, dtype=np.uint8)
    for start in range(0, size, PIECE):
        piece = stream.read(min(PIECE, size - start))
        if len(piece) < min(PIECE, size - start):
            raise ValueError("it holds less than it claims")
        data[start : start + PIECE] = np.frombuffer(piece, dtype=np.uint8)
    return as_array(data, shape, dtype, "F" if is_fortran else "C")


def as_array(data: Any, shape: tuple[int, ...], dtype: np.dtype, order: Literal["C", "F"]) -> np.ndarray:
    """An array of numbers or text over some bytes; ValueError if they are no such."""
    array: np.ndarray = np.ndarray(shape, dtype, data, order=order)
    if dtype.kind == "U":  # on characters that do not exist Python fails with an internal error
        letters: np.ndarray = np.ndarray(array.nbytes // 4, f"{dtype.byteorder}u4", data)
        if (letters > MAX_CHARACTER).any():
            raise ValueError("it holds characters that do not exist")
    return array.view(np.uint8) != 0 if dtype.kind == "b" else array


def _fault(path: str | Path, error: Exception) -> str:
    """Why an archive cannot be read, without the bytes that zipfile quotes."""
    if isinstance(error, MemoryError):
        return "it takes more memory than there is"
    if isinstance(error, NotImplementedError):
        return "it is packed in a way that Python does not know; save it again with numpy.savez_compressed"
    if isinstance(error, RuntimeError):
        return "it is locked with a password"
    return "it is damaged" if is_zipfile(path) else "it is no zip archive, which an npz file is"


def read_header(stream: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Shape, whether the order is Fortran's, and dtype of an npy stream, left at the first value."""
    is_first = npy.read_magic(stream) == (1, 0)
    length = stream.read(2 if is_first else 4)
    if (size := int.from_bytes(length, "little")) > MOST_HEADER:
        raise ValueError("its header is longer than any")
    return _parsed(is_first, length + stream.read(size))


@lru_cache(maxsize=256)  # a library's files have like headers, and parsing takes longest
def _parsed(is_first: bool, header: bytes) -> tuple[tuple[int, ...], bool, np.dtype]:
    """What the header of an npy stream of the first or a later version of the format says."""
    return (npy.read_array_header_1_0 if is_first else npy.read_array_header_2_0)(io.BytesIO(header))
