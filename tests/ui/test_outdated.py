# SPDX-License-Identifier: GPL-3.0-or-later
"""What does not belong to the study as it is now is grey, and says why and what mends it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from unittest.mock import MagicMock

import bpy
import pytest

from w2w.ui.jobs import jobs, preferences
from w2w.ui.panels.placement import W2W_PT_placement
from w2w.ui.panels.results import W2W_PT_findings
from w2w.ui.panels.steps import W2W_PT_signals
from w2w.ui.panels.top import W2W_PT_main
from w2w.ui.study import signal_cache, state
from w2w.ui.study.lists import advice_of, answer_of
from w2w.ui.study.pages import turn_to
from w2w.ui.viewport.legend import legend

from .made_study import make_study
from .test_panels import draw, view_of_panels

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


def words(layout: MagicMock) -> str:
    """All that labels say."""
    calls = [call for call in layout.mock_calls if call[0].endswith("label")]
    return " ".join(call.kwargs["text"] for call in calls)


def buttons(layout: MagicMock) -> list[str]:
    """The operators of all buttons."""
    return [call.args[0] for call in layout.mock_calls if call[0].endswith("operator")]


def relabel(body: bpy.types.Object) -> None:
    """Give a clip another activity."""
    body.w2w.clips[0].activity = body.w2w.clips[-1].activity


def reshape(body: bpy.types.Object) -> None:
    """Move a slider."""
    body.w2w.shape.muscle = 0.5


def lose_armature(body: bpy.types.Object) -> None:
    """Delete the bones."""
    bpy.data.objects.remove(body.parent)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (relabel, "Clips, labels or settings have changed since the ranking"),
        (reshape, "The body, the spots or the sensor have changed since the signals were baked"),
        (lose_armature, "The body has lost its armature: undo that (Ctrl Z), or add a body"),
    ],
)
def test_a_changed_study_is_said_to_be_out_of_date(
    library: Path, change: Callable[[bpy.types.Object], None], why: str
) -> None:
    body = make_study(library)
    assert state.outdated(body) == ""
    fresh = draw(W2W_PT_findings, view_of_panels())
    assert fresh.column().active is True
    assert "w2w.run_all" not in buttons(fresh)
    change(body)
    assert state.outdated(body) == why
    shown = draw(W2W_PT_findings, view_of_panels())
    assert shown.column().active is False
    assert why in words(shown)
    assert ("w2w.run_all" in buttons(shown)) == (change is not lose_armature)
    turn_to("CLIPS")
    assert why in words(draw(W2W_PT_main, view_of_panels()))
    assert legend(body.w2w, state.utility_of(body.w2w)).note == "out of date"


def test_a_study_without_its_armature_cannot_run(library: Path) -> None:
    body = make_study(library)
    lose_armature(body)
    assert not bpy.ops.w2w.run_all.poll()


def test_signals_that_are_gone_from_the_cache_lose_their_tick(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(signal_cache, "LOOK", 0.0)
    body = make_study(library)
    assert W2W_PT_signals.is_done(None, body)
    for path in preferences.cache_folder().rglob(f"{body.w2w.clips[0].signals}*"):
        path.unlink()
    assert not W2W_PT_signals.is_done(None, body)
    said = words(draw(W2W_PT_signals, view_of_panels()))
    assert "8 of 9 clips are up to date; the signals of 1 are gone from the cache" in said


@pytest.mark.slow
def test_a_sensor_of_the_set_is_a_row_that_opens_into_its_card(library: Path) -> None:
    body = make_study(library)
    body.w2w.max_places = 1
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    (card,) = [card for card in advice_of(body.w2w)["cards"] if card["patch"] == body.w2w.worn[0].patch]
    closed = words(draw(W2W_PT_placement, view_of_panels()))
    assert f"{card['slip_cm']:.0f} cm" in closed
    assert card["in_words"] not in closed
    body.w2w.worn[0].is_open = True
    assert card["in_words"] in words(draw(W2W_PT_placement, view_of_panels()))


def test_the_answer_is_said_once_and_what_else_was_done_stays(library: Path) -> None:
    body = make_study(library)
    sentence = answer_of(body.w2w)["sentence"]
    jobs.message = jobs.Message(f"Done: {sentence} Not baked: one.", False, "Run All")
    said = []
    for page in ("CLIPS", "ANSWER"):
        turn_to(page)
        said.append(words(draw(W2W_PT_main, view_of_panels())))
    assert said[0].startswith("Done: ")
    assert "Done" not in said[1]
    assert "Not baked: one." in said[1]
