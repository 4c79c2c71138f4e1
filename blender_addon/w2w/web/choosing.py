# SPDX-License-Identifier: GPL-3.0-or-later
"""Choosing again in a finished study, in a worker that remembers it."""

import json
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..core.findings.advice_content import advice_content, need_content, place_content, with_needs
from ..core.findings.cautions import Caution
from ..core.findings.pilot import of_folder
from ..core.imu.recording_folder import outlines
from ..core.parameters import with_values
from ..core.selection.advice import Advice
from ..core.selection.joint import grow_unwished
from ..core.study.choosing import Choices, compare_places, find_needs
from ..core.study.config import StudyConfig
from ..core.study.results import StudyResults
from ..headless.commands.pilot import write_pilot
from ..headless.commands.place import CHOICE, Wishes, chosen_content
from ..headless.options import words
from ..report.page import report_page


@lru_cache(maxsize=1)
def _opened(
    out: Path,
    written: int,  # noqa: ARG001
) -> Choices[StudyResults]:
    """Choices in a results folder as it was `written`."""
    study = StudyResults.load(out)
    return Choices(study, study.config())


def get_ready(out: Path) -> None:
    """Choose as the run did, and find what other wishes need, too."""
    choose_again(out, {"compare": ""})
    tests = _opened(out, _written(out)).tests
    if tests:
        grow_unwished(tests)


def choose_again(out: Path, wishes: dict[str, Any]) -> dict[str, Any]:
    """What `w2w place` would choose, or compare, in a results folder; "" takes back a wish of the run."""
    if wishes["compare"]:
        study = _opened(out, _written(out)).study
        scores = compare_places(study, words(wishes["compare"]))
        return {"compared": [place_content(score, study.patches) for score in scores]}
    again, _, advice = _chosen(out, wishes)
    found = [Caution(**each) for each in again.summary["cautions"]]
    return advice_content(advice, again.utility, again.patches, found)


def report_again(out: Path, wishes: dict[str, Any]) -> str:
    """The report of a results folder under other wishes, as HTML."""
    return report_page(_shown(out, wishes))


def report_needing(out: Path, wishes: dict[str, Any]) -> str:
    """The same, whose first card says how cheap the sensor there may be, as `w2w need` does."""
    shown = _shown(out, wishes)
    summary, cards = shown.summary, shown.cards
    vars(shown)["summary"] = summary | {"cards": cards[:1]}
    found = [need_content(one) for one in find_needs(shown)]
    vars(shown)["summary"] = summary | {"cards": with_needs(cards, found)}
    return report_page(shown)


def _shown(out: Path, wishes: dict[str, Any]) -> StudyResults:
    """A results folder's study as its report shows it under other wishes."""
    again, config, advice = _chosen(out, wishes)
    study = _opened(out, _written(out)).study
    shown = replace(again, parameters=config.as_dict())
    vars(shown)["summary"] = study.summary | chosen_content(study, shown, config, advice)
    return shown


def cheapest(out: Path, place: str) -> list[dict[str, Any]]:
    """What `w2w need` finds at products and places, or at those that the run recommends."""
    return [need_content(one) for one in find_needs(StudyResults.load(out), words(place))]


def pilot_by(out: Path, asked: tuple[Path, str]) -> dict[str, Any]:
    """What `w2w pilot` finds by a folder of recordings worn at a place, written as it does."""
    found = of_folder(StudyResults.load(out), *asked)
    write_pilot(out, found)
    return found.content()


def signals_of(_out: Path, asked: tuple[Path, str]) -> dict[str, Any]:
    """How the recordings in a folder look."""
    return outlines(asked[0])


def _written(out: Path) -> int:
    return (out / "summary.json").stat().st_mtime_ns


def _chosen(out: Path, wishes: dict[str, Any]) -> tuple[StudyResults, StudyConfig, Advice]:
    return _chosen_by(out, _written(out), json.dumps(wishes))


@lru_cache(maxsize=4)
def _chosen_by(out: Path, written: int, asked: str) -> tuple[StudyResults, StudyConfig, Advice]:
    """A choice by wishes as JSON: its sentence is asked for, then its report."""
    wishes = json.loads(asked)
    choices = _opened(out, written)
    figures = [name for name, each in CHOICE.items() if not each.is_list]
    cleared = {name: CHOICE[name].default for name in figures if wishes.get(name) == ""}
    given = {name: wishes[name] for name in wishes if name in CHOICE and name not in cleared}
    config = with_values(Wishes(**given).over(choices.study), cleared)
    choices = choices.weighed(config)
    return choices.study, config, choices.under(config)
