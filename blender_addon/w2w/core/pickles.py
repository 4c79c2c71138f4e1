# SPDX-License-Identifier: GPL-3.0-or-later
"""Pickles of models and of motions opened without trust: arrays are built, everything else is refused.

The official files are Python 2 pickles that name classes of numpy, scipy.sparse and chumpy. A pickle
can name any function and have it called, so only stand-ins written here are ever found.
"""

import pickle
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, BinaryIO
from zipfile import ZipFile

import numpy as np
from scipy import sparse

from .files import DAMAGED, MOST_BYTES, read_arrays as read_plain_arrays, read_header


class RefusedPickleError(ValueError):
    """A pickle that asks for more than arrays, or is damaged; the message says what."""


class _State:
    """Something a pickle builds by its state alone: takes a dict of attributes, runs nothing."""

    def __init__(self, *_: Any) -> None:
        self.state: dict[str, Any] = {}

    def __setstate__(self, state: Any) -> None:
        self.state = state if isinstance(state, dict) else {}


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
    """numpy's `_reconstruct`: an empty array, whatever size was claimed; its state follows."""
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


def _latin(text: str, _encoding: str = "latin1") -> bytes:
    """`_codecs.encode`, with which Python 3 writes bytes in old pickles."""
    return text.encode("latin-1")


class _NumpyArray:
    """Stands for `numpy.ndarray` and `object` where a pickle only names them."""


FOUND: dict[tuple[str, str], Callable | type] = {
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
    ("scipy", "csc_matrix"): _SparseMatrix,
    ("scipy", "csc_array"): _SparseMatrix,
    ("scipy", "csr_matrix"): _CsrMatrix,
    ("scipy", "csr_array"): _CsrMatrix,
}
"""All that a model file may name, by package, and what it gets instead."""


class _ArrayUnpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        package = module.partition(".")[0]
        if package == "chumpy":
            return _Chumpy
        try:
            return FOUND[package, name]
        except KeyError:
            raise RefusedPickleError(
                f"it names {module}.{name}: a model or motion holds arrays only, so it was not opened"
            ) from None


def read_arrays(stream: BinaryIO, wanted: Collection[str]) -> dict[str, Any]:
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
            content = _load(stream) if dtype.hasobject else None
    except DAMAGED:
        content = None  # the plain reader says what is wrong
    if content is None:
        return read_plain_arrays(path, (name,), MOST_BYTES)[name]
    if isinstance(content, np.ndarray) and content.size == 1:
        content = content.item()
    return _plain(content)


def read_npy_object(path: str | Path) -> Any:
    """The pickled content of an npy file, opened as warily; None where it holds numbers, or is damaged.

    Raises RefusedPickleError if it names anything but arrays.
    """
    with Path(path).open("rb") as stream:
        try:
            _, _, dtype = read_header(stream)
        except (ValueError, *DAMAGED):
            return None  # the plain reader says what is wrong
        content = _load(stream) if dtype.hasobject else None
    return content.item() if isinstance(content, np.ndarray) and content.size == 1 else content


def _load(stream: BinaryIO) -> Any:
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
