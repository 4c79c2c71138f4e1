# SPDX-License-Identifier: GPL-3.0-or-later
"""Matrix products and solutions by SciPy's BLAS and LAPACK: stays until Blender 4.5 LTS ends.

NumPy 1.26, which Blender 4 brings, carries an OpenBLAS that takes processors made since for the oldest it
knows and works at a third of their speed or less; SciPy's is newer. If so, synthesis, features and
the whole road from a motion to signals take 1.3 to 1.5 times as long by NumPy (`benchmarks/blas_speed.py`);
the ridge map took 1.05 times, so it multiplies by NumPy. Its Cython interface, unlike the
Python one, lets go of the interpreter's lock and takes parts of larger arrays as they lie.
"""

import ctypes
from collections.abc import Callable
from functools import lru_cache
from types import ModuleType

import numpy as np
from scipy.linalg import cython_blas, cython_lapack

PREFIXES = {np.dtype(np.float32): ("s", ctypes.c_float), np.dtype(np.float64): ("d", ctypes.c_double)}
"""First letter of a routine's name, and the type in C, for each type of number."""


def multiply(a: np.ndarray, b: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
    """The product a @ b of a matrix (m, k) with another (k, n), or with each of a stack (..., k, n).

    Both are float32 or both float64; matrices laid out neither in rows nor in columns are copied first. The
    product is written to `out`, if given: parts of the rows of a larger array will do.

    Raises ValueError if shapes or types do not go together, or the rows of `out` are not whole.
    """
    product = _routine(cython_blas, a.dtype, "gemm", "cciiinpipinpi")
    shape = (*b.shape[:-2], a.shape[0], b.shape[-1])
    if out is None:
        out = np.empty(shape, dtype=a.dtype)
    if b.shape[-2] != a.shape[1] or out.shape != shape or not a.dtype == b.dtype == out.dtype:
        raise ValueError(f"cannot write {a.dtype} {a.shape} @ {b.dtype} {b.shape} to {out.dtype} {out.shape}")
    if 0 in (*shape, a.shape[1]):
        out[...] = 0
        return out
    a, turn_a, stride_a = _laid_out(a)
    b, turn_b, stride_b = _laid_out(b)
    stride_out = _row_stride(out)
    if stride_out is None:
        raise ValueError("the rows of the product's place must be whole")
    # BLAS counts in columns, so it is told of the transposes: out' = b' a'
    sizes = (_size(shape[-1]), _size(a.shape[0]), _size(a.shape[1]))
    times_a = (_size(stride_b), a.ctypes.data, _size(stride_a), _number(a.dtype, 0.0))
    one, stride = _number(a.dtype, 1.0), _size(stride_out)
    for address_b, address_out in zip(_addresses(b), _addresses(out), strict=True):
        product(turn_b, turn_a, *sizes, one, address_b, *times_a, address_out, stride)
    return out


def add_square(upper: np.ndarray, rows: np.ndarray, times: float = 1.0) -> None:
    """Add rows' @ rows, or a multiple, to the upper triangle of a matrix: half the work of a product.

    `upper` (k, k) lies in rows and keeps what stands below its diagonal; `rows` (m, k) is of the same type,
    float32 or float64. Raises ValueError if they do not go together.
    """
    stride = _row_stride(upper)
    m, k = rows.shape
    if upper.shape != (k, k) or upper.dtype != rows.dtype or stride is None or min(m, k) == 0:
        raise ValueError(f"cannot add the square of {rows.dtype} {rows.shape} to {upper.dtype} {upper.shape}")
    rows, turned, stride_rows = _laid_out(rows)
    update = _routine(cython_blas, upper.dtype, "syrk", "cciinpinpi")
    update(
        b"L", turned, _size(k), _size(m), _number(upper.dtype, times), rows.ctypes.data, _size(stride_rows),
        _number(upper.dtype, 1.0), upper.ctypes.data, _size(stride),
    )  # fmt: skip


def multiply_lower(lower: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The product of a lower triangular matrix (n, n) with another (n, k), in half the work of a full one.

    Nothing above the diagonal of `lower` is read. Raises ValueError if shapes or types do not go together.
    """
    product = np.array(b, order="C")
    n, k = product.shape
    if lower.shape != (n, n) or lower.dtype != product.dtype or min(n, k) == 0:
        raise ValueError(f"cannot multiply {lower.dtype} {lower.shape} by {b.dtype} {b.shape}")
    lower, turned, stride = _laid_out(lower)
    times = _routine(cython_blas, lower.dtype, "trmm", "cccciinpipi")
    times(
        b"R", b"U" if turned == b"N" else b"L", turned, b"N", _size(k), _size(n), _number(lower.dtype, 1.0),
        lower.ctypes.data, _size(stride), product.ctypes.data, _size(k),
    )  # fmt: skip
    return product


def solve_positive(upper: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Solve a system whose matrix is symmetric and positive definite, by Cholesky's factors.

    `upper` (k, k) lies in rows; nothing below its diagonal is read, and its upper triangle is overwritten.
    `rows` (m, k) holds a right-hand side a row, the result a solution a row.

    Raises ValueError if shapes or types do not go together, and LinAlgError if the matrix is not positive
    definite.
    """
    solutions = np.array(rows, order="C")
    m, k = solutions.shape
    stride = _row_stride(upper)
    if upper.shape != (k, k) or upper.dtype != rows.dtype or stride is None or min(m, k) == 0:
        raise ValueError(f"cannot solve {upper.dtype} {upper.shape} for {rows.dtype} {rows.shape}")
    failed_at = ctypes.c_int(0)
    solve = _routine(cython_lapack, upper.dtype, "posv", "ciipipip")
    solve(
        b"L", _size(k), _size(m), upper.ctypes.data, _size(stride), solutions.ctypes.data, _size(k),
        ctypes.byref(failed_at),
    )  # fmt: skip
    if failed_at.value:
        raise np.linalg.LinAlgError(f"the matrix is not positive definite (row {failed_at.value})")
    return solutions


def _addresses(matrices: np.ndarray) -> list[int]:
    """Address in memory of each matrix of a stack."""
    addresses = [matrices.ctypes.data]
    for length, step in zip(matrices.shape[:-2], matrices.strides, strict=False):
        addresses = [address + i * step for address in addresses for i in range(length)]
    return addresses


@lru_cache(maxsize=1024)
def _size(number: int) -> object:
    """A number as BLAS takes it, by reference."""
    return ctypes.byref(ctypes.c_int(number))


def _laid_out(matrix: np.ndarray) -> tuple[np.ndarray, bytes, int]:
    """The matrix, how BLAS shall read it, and the distance of its rows (or columns) in numbers."""
    for turned, view in ((b"N", matrix), (b"T", matrix.swapaxes(-1, -2))):
        stride = _row_stride(view)
        if stride is not None:
            return matrix, turned, stride
    return np.ascontiguousarray(matrix), b"N", matrix.shape[-1]


def _row_stride(matrix: np.ndarray) -> int | None:
    """Numbers from one row to the next where each row is whole, else None."""
    rows, row = matrix.shape[-2:]
    down, along = matrix.strides[-2:]
    if row > 1 and along != matrix.itemsize:
        return None
    if rows == 1:
        return row
    return down // matrix.itemsize if down >= row * matrix.itemsize and down % matrix.itemsize == 0 else None


@lru_cache(maxsize=16)
def _number(dtype: np.dtype, value: float) -> object:
    """A factor as BLAS takes it, by reference."""
    return ctypes.byref(PREFIXES[dtype][1](value))


@lru_cache(maxsize=16)
def _routine(library: ModuleType, dtype: np.dtype, name: str, arguments: str) -> Callable[..., None]:
    """A routine for a type of number; `arguments` has a c for each letter it takes, else a pointer."""
    if dtype not in PREFIXES:
        raise ValueError(f"matrices must be float32 or float64, not {dtype}")
    capsule = library.__pyx_capi__[PREFIXES[dtype][0] + name]
    name_of, pointer_of = ctypes.pythonapi.PyCapsule_GetName, ctypes.pythonapi.PyCapsule_GetPointer
    name_of.restype, name_of.argtypes = ctypes.c_char_p, [ctypes.py_object]
    pointer_of.restype, pointer_of.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    types = [ctypes.c_char_p if kind == "c" else ctypes.c_void_p for kind in arguments]
    return ctypes.CFUNCTYPE(None, *types)(pointer_of(capsule, name_of(capsule)))
