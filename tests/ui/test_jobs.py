# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs in parts, and what is said of the time that they still take."""

from __future__ import annotations

from collections.abc import Generator
from types import SimpleNamespace

import pytest

from w2w.ui.jobs import jobs
from w2w.ui.jobs.jobs import Step, part, time_left


@pytest.mark.parametrize(
    ("fraction", "seconds", "text"),
    [
        (0.5, 2.0, ""),
        (0.01, 20.0, ""),
        (1.0, 20.0, ""),
        (0.5, 20.0, "about 20 s left"),
        (0.999, 20.0, "about 1 s left"),
        (0.25, 100.0, "about 5 min left"),
    ],
)
def test_the_time_left_is_said_as_soon_as_it_can_be_told(fraction: float, seconds: float, text: str) -> None:
    assert time_left(fraction, seconds) == text


def made(closed: list[str]) -> Generator[Step, None, str]:
    """Steps that note that they were closed."""
    try:
        for fraction in (0.0, 0.5, 1.0):
            yield Step(fraction, "working")
        return "done"
    finally:
        closed.append("closed")


def test_a_part_runs_from_its_fraction_to_the_next_and_gives_what_it_did() -> None:
    closed: list[str] = []
    steps = part(made(closed), 0.2, 0.6)
    assert [next(steps).fraction for _ in range(3)] == pytest.approx([0.2, 0.4, 0.6])
    with pytest.raises(StopIteration, match="done"):
        next(steps)


def test_a_part_that_is_ended_ends_its_own_steps() -> None:
    closed: list[str] = []
    steps = part(made(closed), 0.0, 1.0)
    next(steps)
    steps.close()
    assert closed == ["closed"]


@pytest.mark.parametrize("show", [jobs.show_error, jobs.show_done])
def test_an_outcome_holds_nothing_that_blenders_terminal_obeys(show, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jobs, "message", None)
    said: list[str] = []
    show(SimpleNamespace(report=lambda _kind, text: said.append(text)), "clip \x1b]0;x\x07 is done")
    assert said == [jobs.message.text] == ["clip %1B]0;x%07 is done"]


def failing(error: Exception) -> Generator[Step, None, str]:
    """Steps that fail."""
    yield Step(0.0, "working")
    raise error


UNFORESEEN = "Job failed, please report this and what the system console says: "


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (ValueError("Rank again first"), "Rank again first"),
        (ValueError(), f"{UNFORESEEN}ValueError"),
        (
            RuntimeError("Context missing active object"),
            f"{UNFORESEEN}RuntimeError: Context missing active object",
        ),
        (KeyError("walk"), f"{UNFORESEEN}KeyError: 'walk'"),
        (
            MemoryError(),
            "Job needs more memory than is free: close other programs, or take fewer spots",
        ),
    ],
)
@pytest.mark.usefixtures("blender")
def test_whatever_a_job_raises_is_a_sentence(
    error: Exception, sentence: str, capsys: pytest.CaptureFixture
) -> None:
    said: list[str] = []
    operator = SimpleNamespace(report=lambda _kind, text: said.append(text))
    assert jobs.run_now(operator, "Job", failing(error)) == {"CANCELLED"}
    assert said == [sentence]
    assert jobs.message == jobs.Message(sentence, True, "Job")
    assert jobs.running is None
    assert ("Traceback" in capsys.readouterr().err) == (sentence != "Rank again first")
