# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a job is, in every window; `tests/gui` has real ones."""

from __future__ import annotations

import time
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from w2w.ui.jobs import jobs, windows as job_windows
from w2w.ui.jobs.windows import SHOWN_EVERY, W2W_OT_run_job

from .test_jobs import made


def window_of(number: int, drawn: list[str]) -> SimpleNamespace:
    """A window that notes what is drawn in it and what its status bar says."""

    def can_draw(kind: str) -> SimpleNamespace:
        return SimpleNamespace(type=kind, tag_redraw=lambda: drawn.append(kind))

    view = can_draw("VIEW_3D")
    view.regions = [can_draw("WINDOW"), can_draw("UI")]
    return SimpleNamespace(
        screen=SimpleNamespace(areas=[view, can_draw("OUTLINER")]),
        workspace=SimpleNamespace(status_text_set=lambda text: drawn.append(f"{number} says {text}")),
        as_pointer=lambda: number,
    )


def test_progress_is_drawn_a_few_times_a_second_and_in_the_sidebars_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    drawn: list[str] = []
    context = SimpleNamespace(
        window_manager=SimpleNamespace(windows=[window_of(number, drawn) for number in (1, 2)]),
        temp_override=lambda **_: nullcontext(),
    )
    job = jobs.Job("Bake Signals", made([]), text="walking", fraction=0.5, windows={1: "timer", 2: "timer"})
    shown = SimpleNamespace(job=job, due=float("-inf"))
    monkeypatch.setattr(jobs, "running", job)
    for _ in range(100):
        W2W_OT_run_job.show(shown, context)
    text = "Bake Signals: 50%   walking      Esc: cancel"
    assert drawn == [f"1 says {text}", f"2 says {text}", "UI", "UI"]
    later = time.monotonic() + SHOWN_EVERY
    monkeypatch.setattr(time, "monotonic", lambda: later)
    W2W_OT_run_job.show(shown, context)
    assert drawn[4:] == drawn[:4]
    job_windows._set_status(context, None)
    jobs.redraw(context)
    assert drawn[8:] == ["1 says None", "2 says None", "VIEW_3D", "VIEW_3D"]


def test_a_window_that_is_slow_to_draw_is_drawn_less_often(monkeypatch: pytest.MonkeyPatch) -> None:
    """A redraw of a second takes a fifth of the job's time, not five sixths."""
    now, redraws = 100.0, []
    monkeypatch.setattr(time, "monotonic", lambda: now)
    monkeypatch.setattr(job_windows, "advance", lambda *_: None)
    job = jobs.Job("Run All", made([]))
    monkeypatch.setattr(jobs, "running", job)
    shown = SimpleNamespace(job=job, drives=True, shown=0.0, due=float("-inf"))

    def show(context: object) -> None:
        before = shown.shown
        W2W_OT_run_job.show(shown, context)
        if shown.shown != before:
            redraws.append(now)

    shown.show = show
    manager = SimpleNamespace(windows=[])
    context = SimpleNamespace(window_manager=manager)
    monkeypatch.setattr(job_windows, "_set_status", lambda *_: None)
    while now < 120.0:
        drawn = len(redraws)
        W2W_OT_run_job.modal(shown, context, SimpleNamespace(type="TIMER", value="NOTHING"))
        now += 1.0 if len(redraws) > drawn else 0.03
    gaps = np.diff(redraws)
    np.testing.assert_allclose(gaps, 1 / job_windows.DRAWING, atol=0.1)
