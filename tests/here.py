# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips worked on in the tests' own process, and ranked with less care: both take seconds otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager, nullcontext
from dataclasses import replace

import pytest

from w2w.core.ranking import stream
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.headless.runs import guard, workers

MOST_ORDERS, CHOOSE_ALPHA = stream.MOST_ORDERS, Ridge.choose_alpha
FEW_SENSORS = 3


@contextmanager
def ranked_roughly() -> Iterator[None]:
    """A stream in the fewest orders, the ridge chosen by a few sensors: tests of more are the core's."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stream, "MOST_ORDERS", stream.FEWEST_ORDERS)
        patch.setattr(Ridge, "choose_alpha", _by_few_sensors)
        yield


def _by_few_sensors(ridge: Ridge, *given) -> float:
    return CHOOSE_ALPHA(replace(ridge, tuning_sensors=FEW_SENSORS), *given)


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
