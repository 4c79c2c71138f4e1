# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a job is, in every window; `tests/gui` has real ones."""

from __future__ import annotations

import time
from contextlib import nullcontext
from types import SimpleNamespace

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
    shown = SimpleNamespace(job=job, shown=float("-inf"))
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
