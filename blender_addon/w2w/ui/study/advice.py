# SPDX-License-Identifier: GPL-3.0-or-later
"""A choice of sensors as the study keeps it: the very content that `w2w place` writes, as text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import bpy

from .state import advice_settings


def keep(study: bpy.types.PropertyGroup, content: Mapping[str, Any]) -> None:
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
    """Where to wear one sensor, as `w2w run` writes it; empty before a ranking."""
    return _read(study.answer_text) if study.answer_text else {}


def forget(study: bpy.types.PropertyGroup) -> None:
    """Forget the choice: its ranking is gone."""
    study.advice_text = study.advised_as = ""
    study.worn.clear()


def advice_of(study: bpy.types.PropertyGroup) -> dict[str, Any] | None:
    """The choice; None where none was made, or wishes or ranking have changed since."""
    if not study.advice_text or study.advised_as != advice_settings(study):
        return None
    return _read(study.advice_text)


def leading(study: bpy.types.PropertyGroup) -> bpy.types.bpy_prop_collection:
    """The set that is marked on the body: the one worn together, else the best spot."""
    return study.worn if len(study.worn) and advice_of(study) is not None else study.chosen


@lru_cache(maxsize=4)
def _read(text: str) -> dict[str, Any]:
    return json.loads(text)
