# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest
from threadpoolctl import OpenBLASController, ThreadpoolController, threadpool_limits

from w2w.core.threads import for_each, unthreaded_products


@pytest.fixture
def two_threads() -> Iterator[None]:
    with threadpool_limits(2, user_api="blas"):
        yield


def blas_threads() -> list[int]:
    """Threads of each matrix library that is loaded, looked up anew."""
    return [library["num_threads"] for library in ThreadpoolController().select(user_api="blas").info()]


@pytest.mark.usefixtures("two_threads")
def test_products_take_one_thread_and_as_many_as_before_afterwards() -> None:
    before = blas_threads()
    with unthreaded_products():
        within = blas_threads()
    assert len(before) >= 1
    assert set(within) == {1}
    assert blas_threads() == before


@pytest.mark.usefixtures("two_threads")
def test_products_within_products_do_not_bring_the_threads_back() -> None:
    with unthreaded_products():
        with unthreaded_products():
            pass
        assert set(blas_threads()) == {1}


@pytest.mark.usefixtures("two_threads")
def test_of_products_that_overlap_the_last_brings_the_threads_back() -> None:
    before = blas_threads()
    first, second = unthreaded_products(), unthreaded_products()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    within = blas_threads()
    second.__exit__(None, None, None)
    assert set(within) == {1}
    assert blas_threads() == before


@pytest.mark.parametrize("threads", ["1", "2"])
def test_every_part_is_worked_on_once(monkeypatch: pytest.MonkeyPatch, threads: str) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", threads)
    done: list[int] = []
    for_each(done.append, range(5))
    assert sorted(done) == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("threads", ["1", "2"])
def test_an_error_in_a_part_is_raised(monkeypatch: pytest.MonkeyPatch, threads: str) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", threads)
    with pytest.raises(ZeroDivisionError):
        for_each(lambda part: 1 // part, [1, 0])


def test_products_take_one_thread_whichever_thread_asked_before() -> None:
    """Threadpoolctl leaves the libraries to the thread that limited them first, as long as it lives."""

    def limited() -> set[int]:
        with unthreaded_products():
            return set(blas_threads())

    threadpool_limits(2, user_api="blas")
    OpenBLASController.clear_controlling_thread(force=True)
    with ThreadPoolExecutor(1) as first, ThreadPoolExecutor(1) as second:
        assert first.submit(limited).result() == second.submit(limited).result() == limited() == {1}
