# SPDX-License-Identifier: GPL-3.0-or-later
"""Pickles of models and of motions opened without trust: arrays are built, everything else is refused.

The official files are Python 2 pickles that name classes of numpy, scipy.sparse and chumpy. A pickle
can name any function and have it called, so only stand-ins written here are ever found.
"""

import io
import math
import os
import pickle
import zlib
from collections import OrderedDict
from collections.abc import Callable, Collection
from pathlib import Path
from typing import IO, Any, ClassVar
from zipfile import ZipFile, is_zipfile

import numpy as np
from scipy import sparse

from .files import DAMAGED, MOST_BYTES, most_unpacked, read_arrays as read_plain_arrays, read_header

PACKED = (b"\x78", b"\x1f\x8b")
MOST_RESULT_BYTES = 2 * 2**30
MOST_NUMBERS = 2**27


class RefusedPickleError(ValueError):
    """A pickle that asks for more than arrays, or is damaged; the message says what."""


class _State:
    """Something a pickle builds by its state alone: takes a dict of attributes, runs nothing."""

    def __init__(self, *_: Any) -> None:
        self.state: dict[str, Any] = {}

    def __setstate__(self, state: Any) -> None:
        self.state = state if isinstance(state, dict) else {}

    def array(self) -> np.ndarray:
        raise RefusedPickleError("it holds an object that is no array")


class _SparseMatrix(_State):
    """A compressed sparse matrix of scipy, whichever version wrote it."""

    layout: type = sparse.csc_matrix

    def array(self) -> np.ndarray:
        shape = self.state.get("_shape", self.state.get("shape"))
        parts = tuple(_plain(self.state.get(name)) for name in ("data", "indices", "indptr"))
        matrix = self.layout(parts, shape=shape)
        matrix.check_format(full_check=True)  # indices out of range would read foreign memory
        return matrix.toarray()


class _CsrMatrix(_SparseMatrix):
    layout = sparse.csr_matrix


class _Chumpy(_State):
    """A chumpy array: its value ``x``, or a selection ``idxs`` from an array ``a``."""

    def array(self) -> np.ndarray:
        if "x" in self.state:
            return _plain(self.state["x"])
        if {"a", "idxs"} <= self.state.keys():
            chosen = _plain(self.state["a"]).ravel()[_plain(self.state["idxs"])]
            shape = self.state.get("preferred_shape")
            return chosen if shape is None else chosen.reshape(tuple(shape))
        raise RefusedPickleError("it holds a chumpy expression instead of numbers: save the model's values")


def _empty_array(_kind: type, _shape: Any, _dtype: Any) -> np.ndarray:
    """numpy's `_reconstruct`: an empty array, regardless of the claimed size; its state follows."""
    return np.ndarray.__new__(np.ndarray, (0,), np.int8)


def _scalar(dtype: np.dtype, data: Any) -> Any:
    """numpy's `scalar`; text of Python 2 was decoded as latin-1."""
    if dtype.hasobject:
        raise RefusedPickleError("it holds a scalar that is no number")
    raw = data.encode("latin-1") if isinstance(data, str) else bytes(data)
    return np.frombuffer(raw, dtype=dtype, count=1)[0]


def _number_type(text: str, *_: Any) -> np.dtype:
    """`numpy.dtype`; a copy, because its state follows and would change the type everyone shares."""
    return np.dtype(str(text), align=False, copy=True)


def _reconstructed(kind: type, _base: Any, _state: Any) -> _State:
    """`copy_reg._reconstructor`, for the stand-ins only."""
    if not (isinstance(kind, type) and issubclass(kind, _State)):
        raise RefusedPickleError("it builds an object that is no array")
    return kind()


class _JoblibArray(_State):
    """joblib's place for an array whose bytes follow."""

    def read(self, stream: IO[bytes]) -> np.ndarray:
        shape, dtype = tuple(self.state["shape"]), self.state["dtype"]
        if not isinstance(dtype, np.dtype) or dtype.hasobject:
            raise RefusedPickleError("it holds an array of no numbers")
        if self.state.get("numpy_array_alignment_bytes") is not None:
            stream.read(stream.read(1)[0])
        data = stream.read(math.prod(shape) * dtype.itemsize)
        return np.frombuffer(data, dtype).reshape(shape, order=self.state["order"])


def _tensor(storage: np.ndarray, offset: int, size: tuple, stride: tuple, *_: Any) -> np.ndarray:
    """torch's `_rebuild_tensor_v2`: a view of a storage, all of it inside."""
    if storage.ndim != 1 or not storage.flags.c_contiguous or len(size) != len(stride):
        raise RefusedPickleError("it holds an array of no storage")
    if min((offset, *size, *stride)) < 0 or math.prod(size) > MOST_NUMBERS:
        raise RefusedPickleError("it holds an array of an impossible size")
    if math.prod(size) == 0:
        return np.empty(size, storage.dtype)
    last = offset + sum((n - 1) * step for n, step in zip(size, stride, strict=True))
    if last >= storage.size:
        raise RefusedPickleError("it holds an array that reaches beyond its numbers")
    steps = [step * storage.itemsize for step in stride]
    return np.lib.stride_tricks.as_strided(storage[offset:], size, steps, writeable=False)


def _from_buffer(data: Any, dtype: np.dtype, shape: tuple, order: str) -> np.ndarray:
    """numpy's `_frombuffer`, with which protocol 5 writes arrays."""
    return np.frombuffer(data, dtype).reshape(shape, order=order)  # type: ignore[call-overload]


def _latin(text: str, _encoding: str = "latin1") -> bytes:
    """`_codecs.encode`, with which Python 3 writes bytes in old pickles."""
    return text.encode("latin-1")


class _NumpyArray:
    """Stands for `numpy.ndarray` and `object` if a pickle only names them."""


STORAGES = {
    "Float": "<f4", "Double": "<f8", "Half": "<f2", "Long": "<i8", "Int": "<i4", "Short": "<i2",
    "Char": "i1", "Byte": "u1", "Bool": "?",
}  # fmt: skip
"""Kinds of torch's storages, and what numpy calls their numbers: text, which no pickle can change."""

FOUND: dict[tuple[str, str], Any] = {
    ("copy_reg", "_reconstructor"): _reconstructed,
    ("copyreg", "_reconstructor"): _reconstructed,
    ("_codecs", "encode"): _latin,
    ("__builtin__", "object"): _NumpyArray,
    ("__builtin__", "set"): set,
    ("builtins", "object"): _NumpyArray,
    ("builtins", "set"): set,
    ("numpy", "ndarray"): _NumpyArray,
    ("numpy", "dtype"): _number_type,
    ("numpy", "_reconstruct"): _empty_array,
    ("numpy", "scalar"): _scalar,
    ("numpy", "_frombuffer"): _from_buffer,
    ("joblib", "NumpyArrayWrapper"): _JoblibArray,
    ("collections", "OrderedDict"): OrderedDict,
    ("torch", "_rebuild_tensor_v2"): _tensor,
    ("torch", "Size"): tuple,
    **{("torch", f"{kind}Storage"): code for kind, code in STORAGES.items()},
    ("scipy", "csc_matrix"): _SparseMatrix,
    ("scipy", "csc_array"): _SparseMatrix,
    ("scipy", "csr_matrix"): _CsrMatrix,
    ("scipy", "csr_array"): _CsrMatrix,
}
"""The names that a model file may use, by package, and what it gets instead."""


def _stand_in(module: str, name: str) -> Any:
    package = module.partition(".")[0]
    if package == "chumpy":
        return _Chumpy
    try:
        return FOUND[package, name]
    except KeyError:
        raise RefusedPickleError(
            f"it names {module}.{name}: a model or motion holds arrays only, so it was not opened"
        ) from None


class _ArrayUnpickler(pickle.Unpickler):
    find_class = staticmethod(_stand_in)


_fill: Callable[[Any], None] = pickle._Unpickler.dispatch[pickle.BUILD[0]]


class _ResultUnpickler(pickle._Unpickler):  # joblib's own is one, too
    """Unpickles what joblib or torch wrote: their arrays lie in the stream, or in a zip as storages."""

    stack: list[Any]

    def __init__(self, stream: IO[bytes], storage: Callable[[Any], np.ndarray] | None = None) -> None:
        super().__init__(stream, encoding="latin1")
        self._stream, self._storage = stream, storage

    find_class = staticmethod(_stand_in)

    def persistent_load(self, pid: Any) -> np.ndarray:
        if self._storage is None:
            raise RefusedPickleError("it is damaged, or refers to arrays that it does not hold")
        return self._storage(pid)

    def load_build(self) -> None:
        """Fill an object; an array of joblib's follows in the stream."""
        if isinstance(self.stack[-2], type) or not isinstance(self.stack[-2], (_State, np.ndarray, np.dtype)):
            raise RefusedPickleError("it fills something that is no array")
        _fill(self)
        if isinstance(self.stack[-1], _JoblibArray):
            self.stack[-1] = self.stack[-1].read(self._stream)

    dispatch: ClassVar[dict[int, Callable[[Any], None]]] = {
        **pickle._Unpickler.dispatch,
        pickle.BUILD[0]: load_build,
    }


def read_result(path: str | Path) -> Any:
    """Content of a pkl (also joblib's, packed or not) or pt file: containers, numbers, text and arrays.

    Raises RefusedPickleError if it is neither, is damaged, or names anything but these.
    """
    try:
        if is_zipfile(path):
            return _read_torch(path)
        data = Path(path).read_bytes()
        if data.startswith(PACKED):
            unpacker = zlib.decompressobj(wbits=47)  # zlib or gzip
            data = unpacker.decompress(data, min(MOST_RESULT_BYTES, most_unpacked(len(data))))
            if unpacker.unconsumed_tail:
                raise RefusedPickleError("it unpacks to more than any motion needs")
        return _ResultUnpickler(io.BytesIO(data)).load()
    except (RefusedPickleError, OSError):
        raise
    except Exception as error:  # a damaged pickle raises anything
        raise RefusedPickleError("it is damaged, or no pickle of arrays") from error


def _read_torch(path: str | Path) -> Any:
    """Read what torch.save wrote: a zip of a pickle, and one file per storage."""
    with ZipFile(path) as archive:
        most = min(MOST_RESULT_BYTES, most_unpacked(Path(path).stat().st_size))
        if sum(member.file_size for member in archive.infolist()) > most:
            raise RefusedPickleError("it unpacks to more than any motion needs")
        pickled = next(name for name in archive.namelist() if name.endswith("data.pkl"))
        kept: dict[str, np.ndarray] = {}

        def storage(pid: Any) -> np.ndarray:
            _, dtype, key = pid[:3]
            if key not in kept:
                kept[key] = np.frombuffer(
                    archive.read(f"{pickled.removesuffix('data.pkl')}data/{key}"), dtype
                )
            return kept[key]

        return _ResultUnpickler(io.BytesIO(archive.read(pickled)), storage).load()


def read_arrays(stream: IO[bytes], wanted: Collection[str]) -> dict[str, Any]:
    """Contents of a pickled model by name; those `wanted` as ndarrays, from numpy, scipy.sparse or chumpy.

    Raises RefusedPickleError if it is no pickled dict, is damaged, or names anything but arrays.
    """
    content = _load(stream)
    if not isinstance(content, dict):
        raise RefusedPickleError(f"it holds a {type(content).__name__}, not a model's named arrays")
    return {str(name): _plain(value) if name in wanted else value for name, value in content.items()}


def read_npz_member(path: str | Path, name: str) -> np.ndarray:
    """One array of an npz; an object array is opened as warily as a pickled model.

    Raises RefusedPickleError if the array is a pickle that names anything but arrays.
    """
    try:
        with ZipFile(path) as archive, archive.open(f"{name}.npy") as stream:
            _, _, dtype = read_header(stream)
            size, held = archive.getinfo(f"{name}.npy").file_size, archive.fp
            if dtype.hasobject and size > most_unpacked(held.seek(0, os.SEEK_END) if held else 0):
                raise RefusedPickleError(f"it would unpack to {size / 2**30:.1f} GiB, which no model does")
            content = _load(stream) if dtype.hasobject else None
    except DAMAGED:
        content = None  # the plain reader says what is wrong
    if content is None:
        return read_plain_arrays(path, (name,), MOST_BYTES)[name]
    if isinstance(content, np.ndarray) and content.size == 1:
        content = content.item()
    return _plain(content)


def read_npy_object(path: str | Path) -> Any:
    """The pickled content of an npy file, opened with the same care; None if it holds numbers or is damaged.

    Raises RefusedPickleError if it names anything but arrays.
    """
    with Path(path).open("rb") as stream:
        try:
            _, _, dtype = read_header(stream)
        except (ValueError, *DAMAGED):
            return None  # the plain reader says what is wrong
        content = _load(stream) if dtype.hasobject else None
    return content.item() if isinstance(content, np.ndarray) and content.size == 1 else content


def _load(stream: IO[bytes]) -> Any:
    try:
        return _ArrayUnpickler(stream, encoding="latin1").load()
    except RefusedPickleError:
        raise
    except Exception as error:  # a damaged pickle raises anything
        raise RefusedPickleError(f"it cannot be read as a pickled model or motion: {error}") from error


def _plain(value: Any) -> np.ndarray:
    if isinstance(value, _State):
        value = value.array()
    if not isinstance(value, np.ndarray) or value.dtype.hasobject:
        raise RefusedPickleError(f"it holds a {type(value).__name__} where an array of numbers is expected")
    return value
