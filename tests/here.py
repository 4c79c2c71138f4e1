# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips worked on in the tests' own process: a worker takes seconds to start."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager, nullcontext

import pytest

from w2w.headless.runs import guard, workers


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
