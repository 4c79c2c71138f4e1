# SPDX-License-Identifier: GPL-3.0-or-later
"""What pickles of numpy, scipy, chumpy, joblib and torch name, made here of plain arrays.

No value of a file reaches the state of a NumPy type or array: NumPy believes what is set there, and a type
that hides an object makes it write to any address.
"""

import math
import re
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .files import as_array
from .unpickler import ITEM_BYTES, RefusedPickleError, StandIn, Unpickler, pairs

CODE = re.compile(r"[<>|=]?(b1|[iu][1248]|f[248]|[SU][1-9]\d{0,4}|O[48]?)")
"""Types of numbers and text as pickles write them; what is of type O becomes lists."""

MOST_DIMENSIONS = 32


class _Kind(StandIn):
    """A `numpy.dtype`: one of plain numbers or text, in the byte order that its state says."""

    def __init__(self, text: str) -> None:
        if not isinstance(text, str) or not (found := CODE.fullmatch(text)):
            raise RefusedPickleError("it holds an array of neither numbers nor text")
        self.dtype = np.dtype("O" if "O" in found[1] else text)
        self.native = self.dtype.newbyteorder("=")

    def filled(self, state: Any, _pickled: Unpickler) -> "_Kind":
        if type(state) is tuple and all(part is None or type(part) in (int, str) for part in state):
            for kind in (self.dtype.newbyteorder("<"), self.dtype.newbyteorder(">")):
                if state == kind.__reduce__()[2]:
                    return _Kind(kind.str)
        raise RefusedPickleError("it holds an array of a type of its own making")


def _spent(pickled: Unpickler, kind: Any, shape: Any) -> int:
    """Number of items in an array; refuses one that no pickle of its size can hold."""
    if not isinstance(kind, _Kind) or not _are_sizes(shape):
        raise RefusedPickleError("it holds an array of an impossible type or size")
    size = math.prod(shape)
    pickled.spend(kind.dtype.itemsize * (size or math.prod(filter(None, shape))))
    return size


def _are_sizes(sizes: Any) -> bool:
    if type(sizes) is not tuple or len(sizes) > MOST_DIMENSIONS:
        return False
    return {*map(type, sizes)} <= {int} and min(sizes, default=0) >= 0


def _array(pickled: Unpickler, kind: Any, shape: Any, data: Any, order: Any) -> Any:
    """An array in the processor's byte order; of objects, lists, or the only one."""
    size = _spent(pickled, kind, shape)
    kinds = (list,) if kind.dtype.hasobject else (str, bytes, memoryview)
    if type(data) not in kinds or len(data) != size * (1 if type(data) is list else kind.dtype.itemsize):
        raise RefusedPickleError("it holds an array of more or less than its shape says")
    if type(data) is list:
        objects = np.empty(size, dtype=object)
        for place, item in enumerate(data):
            objects[place] = item
        return objects.reshape(shape, order=order).tolist()
    raw = data.encode("latin-1") if type(data) is str else data  # text of Python 2
    in_file = type(raw) is memoryview  # anywhere in it, so the numbers lie askew
    return as_array(raw, shape, kind.dtype, order).astype(kind.native, order="K", copy=in_file)


class _Array(StandIn):
    """What numpy's `_reconstruct` makes, an array whose state follows."""

    def filled(self, state: Any, pickled: Unpickler) -> Any:
        _, shape, kind, is_fortran, data = state
        return _array(pickled, kind, shape, data, "F" if is_fortran else "C")


def _scalar(pickled: Unpickler, kind: Any, data: Any) -> Any:
    """numpy's `scalar`, as a number or text of Python."""
    return _array(pickled, kind, (), data, "C").item()


def _from_buffer(
    pickled: Unpickler, data: Any, kind: Any, shape: Any, order: str, axes: tuple[int, ...] | None = None
) -> Any:
    """numpy's `_frombuffer`, with which protocol 5 writes arrays."""
    array = _array(pickled, kind, shape, data, "C" if order == "K" else order)
    return array if axes is None else array.transpose(axes)


class _JoblibArray(StandIn):
    """joblib's place for an array whose bytes follow."""

    def filled(self, state: Any, pickled: Unpickler) -> Any:
        kind, shape = state["dtype"], state["shape"]
        if state.get("numpy_array_alignment_bytes") is not None:
            pickled.take(pickled.byte())
        data = pickled.take(_spent(pickled, kind, shape) * kind.dtype.itemsize)
        return _array(pickled, kind, shape, data, state["order"])


class _Columns(StandIn):
    """A sparse matrix of scipy, compressed by columns, whichever version wrote it."""

    by_rows: ClassVar[bool] = False

    def filled(self, state: Any, pickled: Unpickler) -> np.ndarray:
        shape = state.get("_shape", state.get("shape"))
        values, places, starts = (plain(state[name]) for name in ("data", "indices", "indptr"))
        pickled.spend(values.nbytes + places.nbytes + starts.nbytes)
        counts = np.diff(starts.astype(np.int64))
        lines, width = shape if self.by_rows else shape[::-1]
        fits = len(counts) == lines and starts[0] == 0 and starts[-1] == len(values) == len(places)
        if not _are_sizes(shape) or not fits or (counts < 0).any() or (places < 0).any():
            raise RefusedPickleError("it holds a sparse matrix that is damaged")
        pickled.spend(lines * width * values.itemsize)
        dense = np.zeros((lines, width), values.dtype)
        np.add.at(dense, (np.repeat(np.arange(lines), counts), places), values)  # refuses places beyond
        return dense if self.by_rows else dense.T


class _Rows(_Columns):
    by_rows = True


class _Chumpy(StandIn):
    """A chumpy array: its value ``x``, or a selection ``idxs`` from an array ``a``."""

    fault: ClassVar[str] = "it holds a chumpy expression instead of numbers: save the model's values"

    def filled(self, state: Any, pickled: Unpickler) -> Any:
        if "x" in state:
            return state["x"]
        if not {"a", "idxs"} <= state.keys():
            return self
        values, places, shape = plain(state["a"]), plain(state["idxs"]), state.get("preferred_shape")
        pickled.spend(values.nbytes + places.size * values.itemsize)
        chosen = values.ravel()[places]
        return chosen if shape is None else chosen.reshape(tuple(shape))


@dataclass(frozen=True)
class Storage:
    """A kind of torch's storages."""

    dtype: np.dtype  # of its numbers


def _tensor(pickled: Unpickler, storage: Any, offset: Any, size: Any, stride: Any, *_: Any) -> np.ndarray:
    """torch's `_rebuild_tensor_v2`: an array of some numbers of a storage, all of them inside."""
    if plain(storage).ndim != 1 or not all(map(_are_sizes, ((offset,), size, stride))):
        raise RefusedPickleError("it holds an array of no storage")
    pickled.spend(storage.itemsize * math.prod(filter(None, size)))
    if 0 in size:
        return np.empty(size, storage.dtype)
    steps = [step if n > 1 else 0 for n, step in zip(size, stride, strict=True)]
    if offset + sum((n - 1) * step for n, step in zip(size, steps, strict=True)) >= storage.size:
        raise RefusedPickleError("it holds an array that reaches beyond its numbers")
    bytes_apart = [step * storage.itemsize for step in steps]
    return np.lib.stride_tricks.as_strided(storage[offset:], size, bytes_apart).copy()


def plain(value: Any) -> np.ndarray:
    """An array of numbers or text; RefusedPickleError if it is something else."""
    if not isinstance(value, np.ndarray):
        wrong = f"it holds a {type(value).__name__} where an array of numbers is expected"
        raise RefusedPickleError(value.fault if isinstance(value, StandIn) else wrong)
    return value


def _latin(pickled: Unpickler, text: str, _encoding: str = "latin1") -> bytes:
    """`_codecs.encode`, with which Python 3 writes bytes in old pickles."""
    pickled.spend(len(text))
    return text.encode("latin-1")


def _ordered(pickled: Unpickler, items: Any = ()) -> dict[Any, Any]:
    """A `collections.OrderedDict`; Python 2 gives it all its items."""
    pickled.spend(ITEM_BYTES * len(items))
    return pairs(items)


def _items(_pickled: Unpickler, items: Any = ()) -> Any:
    """A set or a torch.Size, which nobody needs as such."""
    return items


_STORAGES = {
    "Float": "<f4", "Double": "<f8", "Half": "<f2", "Long": "<i8", "Int": "<i4", "Short": "<i2",
    "Char": "i1", "Byte": "u1", "Bool": "?",
}  # fmt: skip

_FOUND: dict[tuple[str, str], Any] = {
    ("copyreg", "_reconstructor"): lambda pickled, kind, *_: kind(pickled),
    ("_codecs", "encode"): _latin,
    ("builtins", "bytes"): lambda _pickled: b"",  # so are those of none written
    ("builtins", "object"): lambda *_: StandIn(),
    ("builtins", "set"): _items,
    ("numpy", "ndarray"): lambda *_: StandIn(),
    ("numpy", "dtype"): lambda _pickled, text, *_: _Kind(text),
    ("numpy", "_reconstruct"): lambda *_: _Array(),
    ("numpy", "scalar"): _scalar,
    ("numpy", "_frombuffer"): _from_buffer,
    ("joblib", "NumpyArrayWrapper"): lambda *_: _JoblibArray(),
    ("collections", "OrderedDict"): _ordered,
    ("torch", "_rebuild_tensor_v2"): _tensor,
    ("torch", "Size"): _items,
    **{("torch", f"{kind}Storage"): Storage(np.dtype(code)) for kind, code in _STORAGES.items()},
    **{("scipy", f"csc_{kind}"): lambda *_: _Columns() for kind in ("matrix", "array")},
    **{("scipy", f"csr_{kind}"): lambda *_: _Rows() for kind in ("matrix", "array")},
}
"""The names that a model or motion may use, by package, and what it gets instead."""

_OF_PYTHON_2 = {"__builtin__": "builtins", "copy_reg": "copyreg"}


def stand_in(module: str, name: str) -> Any:
    """What a pickle gets for a name; RefusedPickleError if that is of no array."""
    package = module.partition(".")[0]
    if package == "chumpy":
        return lambda *_: _Chumpy()
    try:
        return _FOUND[_OF_PYTHON_2.get(package, package), name]
    except KeyError:
        raise RefusedPickleError(
            f"it names {module}.{name}: a model or motion holds arrays only, so it was not opened"
        ) from None
