# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from w2w.core.blas import add_square, multiply, multiply_lower, solve_positive

SIZES = st.integers(1, 40)
LAYOUTS = st.sampled_from(["rows", "columns", "part", "every second", "turned over"])


def laid_out(matrix: np.ndarray, layout: str) -> np.ndarray:
    """The same numbers, lying otherwise in memory."""
    if layout == "columns":
        return np.asfortranarray(matrix)
    if layout == "part":
        return np.pad(matrix, ((1, 2), (3, 4)))[1:-2, 3:-4]
    if layout == "every second":
        return np.repeat(matrix, 2, axis=1)[:, ::2]
    if layout == "turned over":
        return matrix[::-1].copy()[::-1]
    return matrix


@given(SIZES, SIZES, SIZES, LAYOUTS, LAYOUTS, st.sampled_from([np.float32, np.float64]))
def test_it_is_the_matrix_product_however_the_matrices_lie(m, k, n, of_a, of_b, dtype) -> None:
    rng = np.random.default_rng([m, k, n])
    a, b = rng.normal(size=(m, k)), rng.normal(size=(k, n))
    product = multiply(laid_out(a.astype(dtype), of_a), laid_out(b.astype(dtype), of_b))
    assert product.dtype == dtype
    tolerance = 50 * np.finfo(dtype).eps * (np.abs(a) @ np.abs(b) + 1)
    assert (np.abs(product - a @ b) <= tolerance).all()


def test_a_stack_is_multiplied_matrix_by_matrix_into_parts_of_a_larger_array() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(5, 7)), rng.normal(size=(2, 3, 9, 11))[:, :, 1:8, 2:6]
    place = np.zeros((2, 3, 6, 10))
    multiply(a, b, out=place[:, :, :5, 3:7])
    np.testing.assert_allclose(place[:, :, :5, 3:7], a @ b)
    assert np.count_nonzero(place) == 2 * 3 * 5 * 4


def test_products_over_nothing_are_zero() -> None:
    assert np.array_equal(multiply(np.ones((2, 0)), np.ones((0, 3))), np.zeros((2, 3)))


@pytest.mark.parametrize(
    ("a", "b", "out", "said"),
    [
        (np.ones((2, 3)), np.ones((2, 3)), None, "cannot write"),
        (np.ones((2, 3)), np.ones((3, 2), np.float32), None, "cannot write"),
        (np.ones((2, 3)), np.ones((3, 2)), np.ones((3, 2)), "cannot write"),
        (np.ones((2, 3), int), np.ones((3, 2), int), None, "float32 or float64"),
        (np.ones((2, 3)), np.ones((3, 2)), np.ones((2, 4))[:, ::2], "whole"),
    ],
)
def test_what_does_not_go_together_is_refused(a, b, out, said) -> None:
    with pytest.raises(ValueError, match=said):
        multiply(a, b, out)


@given(SIZES, SIZES, SIZES, st.sampled_from([np.float32, np.float64]))
def test_systems_are_solved_by_their_upper_triangle_alone(n, k, m, dtype) -> None:
    rng = np.random.default_rng([n, k, m])
    a, rows = rng.normal(size=(n, k)).astype(dtype), rng.normal(size=(m, k)).astype(dtype)
    whole = a.T.astype(np.float64) @ a
    system = whole.astype(dtype)
    system[np.tril_indices(k, -1)] = np.nan
    system[np.diag_indices(k)] += 1
    solutions = solve_positive(system, rows)
    np.testing.assert_allclose(solutions @ (whole + np.eye(k)), rows, rtol=2e-2, atol=2e-3)
    assert solutions.dtype == dtype


def test_what_cannot_be_solved_is_refused() -> None:
    with pytest.raises(np.linalg.LinAlgError, match="not positive definite"):
        solve_positive(np.diag([1.0, -1.0]), np.ones((1, 2)))
    with pytest.raises(ValueError, match="cannot solve"):
        solve_positive(np.eye(2), np.ones((1, 3)))


@given(SIZES, SIZES, LAYOUTS, st.sampled_from([np.float32, np.float64]))
def test_squares_are_added_to_the_upper_triangle_alone(m, k, layout, dtype) -> None:
    rng = np.random.default_rng([m, k])
    rows, matrix = rng.normal(size=(m, k)).astype(dtype), rng.normal(size=(k, k)).astype(dtype)
    wanted = matrix + np.triu(-2 * rows.T.astype(np.float64) @ rows)
    add_square(matrix, laid_out(rows, layout), -2.0)
    np.testing.assert_allclose(matrix, wanted, rtol=1e-4, atol=1e-4)


@given(SIZES, SIZES, LAYOUTS, st.sampled_from([np.float32, np.float64]))
def test_triangles_are_multiplied_by_what_stands_below_their_diagonal(n, k, layout, dtype) -> None:
    rng = np.random.default_rng([n, k])
    lower, b = rng.normal(size=(n, n)).astype(dtype), rng.normal(size=(n, k)).astype(dtype)
    wanted = np.tril(lower).astype(np.float64) @ b
    before = b.copy()
    product = multiply_lower(laid_out(lower, layout), laid_out(b, layout))
    np.testing.assert_allclose(product, wanted, rtol=1e-4, atol=1e-4)
    np.testing.assert_array_equal(b, before)


def test_squares_and_triangles_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ValueError, match="cannot add"):
        add_square(np.eye(2), np.ones((3, 3)))
    with pytest.raises(ValueError, match="cannot multiply"):
        multiply_lower(np.eye(2), np.ones((3, 3)))
