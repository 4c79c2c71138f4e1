# SPDX-License-Identifier: GPL-3.0-or-later
"""The lists of a study: its activities before a ranking, a designer's wishes, and the sensors chosen by them.

A choice is kept as `w2w place` writes it.
"""

import json
from collections.abc import Container, Mapping
from functools import lru_cache
from typing import Any

import bpy

from ...core.findings.cautions import Caution
from ...core.library.labels import speller
from ...core.selection.constraints import Constraints
from .counting import list_activities
from .state import COST, FORBID, MUST, ONLY, advice_settings, run_of, usable, without_updates


def list_labels(study: bpy.types.PropertyGroup) -> None:
    """List the activities of a study's clips, unless a ranking lists its own; what they count stays."""
    if study.utility_key:
        return
    labels = sorted({clip.activity for clip in usable(study) if clip.activity.strip()})
    if labels == [activity.name for activity in study.activities]:
        return
    with without_updates():
        list_activities(study, labels, run_of(study))


def listed_spelling(study: bpy.types.PropertyGroup, typed: str, what: str, but: Container[str]) -> str:
    """The spelling of an ``activity`` or ``subject`` in the list, `but` for clips with these names."""
    return speller(getattr(clip, what) for clip in study.clips if clip.name not in but)(typed)


def list_wishes(study: bpy.types.PropertyGroup, constraints: Constraints) -> None:
    """List the wishes of a run, in place of those that are there."""
    with without_updates():
        study.wishes.clear()
        for kind, words in ((ONLY, constraints.only), (FORBID, constraints.forbid), (MUST, constraints.must)):
            for where in words:
                add_wish(study, kind, where)
        for where, cost in constraints.costs:
            wish = add_wish(study, COST, where)
            wish.cost, wish.given = cost, repr(cost)  # a property keeps single precision only


def add_wish(study: bpy.types.PropertyGroup, kind: str, place: str = "") -> bpy.types.PropertyGroup:
    """Add a wish at the end of the list."""
    with without_updates():
        wish = study.wishes.add()
        wish.kind, wish.place = kind, place
    return wish


def keep_advice(study: bpy.types.PropertyGroup, content: Mapping[str, Any]) -> None:
    """Keep a choice made under the study's wishes as they are now."""
    study.advice_text, study.advised_as = json.dumps(content), advice_settings(study)
    study.worn.clear()
    for sensor in (content.get("worn_together") or {}).get("places", ()):
        row = study.worn.add()
        row.patch, row.label, row.f1 = sensor["patch"], sensor["name"], sensor["expected_f1_so_far"]
        row.low, row.high = sensor["expected_f1_so_far_interval"]


def keep_answer(study: bpy.types.PropertyGroup, content: Mapping[str, Any]) -> None:
    """Keep where to wear one sensor under the study's wishes, or a sentence that says why nowhere."""
    study.answer_text = json.dumps(content)


def answer_of(study: bpy.types.PropertyGroup) -> dict[str, Any]:
    """Where to wear one sensor, as `w2w run` writes it, or {} before a ranking."""
    if chosen := (advice_of(study) or {}).get("answer"):
        return chosen
    return _read_advice(study.answer_text) if study.answer_text else {}


def cautions_of(study: bpy.types.PropertyGroup) -> list[Caution]:
    """What speaks against the answer."""
    return [Caution(*each) for each in _read_advice(study.cautions_text or "[]")]


def facts_of(clip: bpy.types.PropertyGroup) -> dict[str, Any]:
    """What the record of a clip says, as far as cautions ask."""
    about = {
        "file": clip.file, "skeleton": clip.skeleton, "frame_rate": clip.rate,
        "duration_s": round(clip.n_frames / clip.rate, 4), "scale": clip.scale,
    }  # fmt: skip
    return about | json.loads(clip.facts or "{}")


def comparison_of(study: bpy.types.PropertyGroup) -> tuple[list[dict[str, Any]], str]:
    """The products and places that were compared, as `place_content` says them, and why others cannot be."""
    found = json.loads(study.compared_text or "[]")
    return tuple(found) if len(found) == 2 and isinstance(found[1], str) else ([], "")


def forget_advice(study: bpy.types.PropertyGroup) -> None:
    """Forget the choice: its ranking is gone."""
    study.advice_text = study.advised_as = ""
    study.worn.clear()


def advice_of(study: bpy.types.PropertyGroup) -> dict[str, Any] | None:
    """The choice, or None if there is none, or wishes or ranking have changed since."""
    if not study.advice_text or study.advised_as != advice_settings(study):
        return None
    return _read_advice(study.advice_text)


def leading(study: bpy.types.PropertyGroup) -> bpy.types.bpy_prop_collection:
    """The set that is marked on the body: the one worn together, else the best spot."""
    return study.worn if len(study.worn) and advice_of(study) is not None else study.chosen


@lru_cache(maxsize=4)
def _read_advice(text: str) -> Any:
    return json.loads(text)
