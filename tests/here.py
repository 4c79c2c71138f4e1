# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips worked on in the tests' own process, and ranked with less care: both take seconds otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager, nullcontext
from dataclasses import replace

import pytest

from w2w.core.ranking import halves, stream
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.reading import guard
from w2w.core.selection import promise
from w2w.headless.runs import workers

CHOOSE_ALPHA = Ridge.choose_alpha
FEW_SENSORS = 3


def _by_few_sensors(ridge: Ridge, *given) -> float:
    return CHOOSE_ALPHA(replace(ridge, tuning_sensors=FEW_SENSORS), *given)


ROUGHLY = (
    (stream, "MOST_ORDERS", stream.FEWEST_ORDERS),
    (halves, "SET_HALVINGS", 1),
    (promise, "RANDOM_SETS", 2),
    (Ridge, "choose_alpha", _by_few_sensors),
)
"""Where each thing is that costs care, and less of it."""
CAREFULLY = tuple((where, name, getattr(where, name)) for where, name, _ in ROUGHLY)


@contextmanager
def ranked_roughly() -> Iterator[None]:
    """A stream in the fewest orders, sets by one halving, the ridge by a few sensors: more are the core's."""
    with pytest.MonkeyPatch.context() as patch:
        for there in ROUGHLY:
            patch.setattr(*there)
        yield


class _Here:
    """An executor that works at once, in this process."""

    def submit(self, work, *args) -> Future:
        future: Future = Future()
        future.set_result(work(*args))
        return future

    def shutdown(self, **_) -> None:
        pass


@contextmanager
def clips_here() -> Iterator[None]:
    """No worker process is started in the block, and this one may take what memory it likes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workers, "local_executor", lambda _: nullcontext(_Here()))
        patch.setattr(guard, "_memory_limit", lambda _: nullcontext())
        yield
