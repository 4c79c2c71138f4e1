# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished run as a study of the panel's: from the record in a .blend file, or from a results folder."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import bpy

from ..core.clip_files import STORED
from ..core.study import StudyConfig
from ..scene.packing import pack
from ..scene.patches import empties_by_patch
from ..scene.study_record import StoredClip, StudyRecord, read_record, remove_record
from . import advice, own_placements, results, signal_cache
from .further_sensors import keep_further
from .own_sensor import OWN, keep_own_sensor
from .state import bake_settings, patches_of, rank_settings, without_updates
from .wishes import take_over

SUMMARY = "summary.json"
"""File that a results folder is known by."""


def restore(mesh: bpy.types.Object) -> str:
    """Make a study of the record that lies beside a mesh; says what was found.

    Raises
    ------
    ValueError
        If the record is damaged or not of this mesh; nothing has been changed then.
    """
    record = read_record(mesh)
    placed, chosen = (bpy.data.collections.get(name) for name in record.collections)
    found = empties_by_patch(placed) if placed is not None else {}
    empties = list(found.values())
    if not empties or max(found) >= len(record.patches) or any(item.parent is not mesh for item in empties):
        raise ValueError(f"the patches of '{mesh.name}' are no longer in the file as the run left them")
    check_fits(mesh, record)
    study = mesh.w2w
    study.patch_size = empties[0].empty_display_size
    study.patch_collection, study.chosen_collection = placed, chosen
    for empty in empties:  # without W2W their names are the only marks; the panel has its own
        empty.show_name = empty.show_in_front = False
        empty.select_set(False)
    study.results_near = os.curdir
    actions = {clip.name: bpy.data.actions.get(clip.action) for clip in record.clips if clip.action}
    fill(mesh, record, actions)
    remove_record(mesh)
    return opened_text(mesh)


def check_fits(mesh: bpy.types.Object, record: StudyRecord) -> None:
    """Refuse a record whose parts do not belong together.

    Raises
    ------
    ValueError
    """
    patches, utility = record.patches, record.utility
    if len(patches.labels) != len(mesh.data.vertices) or patches.triangles.max() >= len(patches.labels):
        raise ValueError(f"the patches are of another body than '{mesh.name}'")
    if utility.f1.shape != (len(patches), len(utility.activities)):
        raise ValueError(f"the ranking is of other patches than those of '{mesh.name}'")
    try:
        StudyConfig.from_dict(record.parameters)
    except ValueError as error:
        raise ValueError(f"the parameters of the run cannot be understood: {error}") from error


def fill(mesh: bpy.types.Object, record: StudyRecord, actions: Mapping[str, bpy.types.Action | None]) -> None:
    """Give a body that has its patches everything else that a run found."""
    study, config = mesh.w2w, StudyConfig.from_dict(record.parameters)
    study.is_body, study.has_shape = True, record.is_own_body
    study.parameters = json.dumps(record.parameters)
    take_over(study)
    study.patches_text, study.patches_key = pack(record.patches)
    own_placements.take_over(study)
    _set_parameters(study, config)
    study.clips.clear()
    with without_updates():
        for stored in record.clips:
            _add_clip(study, stored, actions.get(stored.name))
    settings = bake_settings(study)
    for clip in study.clips:
        clip.baked_as = settings if clip.signals else ""
    results.store(mesh, record.utility, rank_settings(study))
    _advise(mesh, record.advice)
    results.show_colours(bpy.context)
    find_folder(study)


def find_folder(study: bpy.types.PropertyGroup) -> None:
    """Look for the results folder that has a study's signals: near the .blend file, else where it was."""
    folders = []
    if study.results_near and bpy.data.filepath:
        folders.append((Path(bpy.data.filepath).parent / study.results_near).resolve())
    if study.results_folder:
        folders.append(Path(study.results_folder))
    found = [folder for folder in folders if (folder / SUMMARY).is_file()]
    if found:
        study.results_folder = str(found[0])


def opened_text(mesh: bpy.types.Object) -> str:
    """What was opened, and which signals are not there, in sentences."""
    study = mesh.w2w
    stored = [clip for clip in study.clips if clip.signals.startswith(STORED)]
    text = f"Opened a finished run: {len(stored)} clips on {len(patches_of(mesh))} patches"
    lost = [clip for clip in stored if not signal_cache.has(clip)]
    if not lost:
        return text
    where = f"in {study.results_folder}" if study.results_folder else "beside this file"
    return (
        f"{text}. The signals of {len(lost)} clips are not {where}: put the file back into its results "
        "folder and open it there, or bake them again (step 4)"
    )


def _set_parameters(study: bpy.types.PropertyGroup, config: StudyConfig) -> None:
    with without_updates():
        study.patch_count, study.patch_seed = config.patches, config.seed
        if config.own_sensor is not None and config.own_sensor.name == config.sensor:
            keep_own_sensor(study, config.own_sensor)
            study.sensor = OWN
        else:
            study.sensor = config.sensor
        study.rate, study.seed = config.synthesis.rate_hz, config.seed
        study.band, study.root_band = config.synthesis.cutoff_hz or 0, config.root_band_hz or 0
        study.convention = config.synthesis.convention
        keep_further(study, config.further)
        study.window_s, study.classifier = config.windows.length_s, config.classifier
        study.folds, study.by_subject = config.folds, config.by_subject
        study.target, study.every_activity = config.target, config.every_activity
        study.max_places = config.max_places or 0


def _add_clip(study: bpy.types.PropertyGroup, stored: StoredClip, action: bpy.types.Action | None) -> None:
    clip = study.clips.add()
    clip.action = action  # before its activity, which is noted on it
    for name, value in (asdict(stored) | {"action": action}).items():
        setattr(clip, name, value)
    clip.stored_as = stored.name if stored.signals else ""
    if action is None and not stored.problem:
        clip.problem = "its motion is no longer where the run left it"


def _advise(mesh: bpy.types.Object, content: Mapping[str, Any]) -> None:
    """Show what the run said of sets; what cannot be understood is left to be chosen anew."""
    try:
        results.advise(mesh, content)
        known = range(len(patches_of(mesh)))
        whole = bool(content) and all(row.patch in known for row in mesh.w2w.worn)
    except (KeyError, TypeError, ValueError):
        whole = False
    if not whole:
        advice.forget(mesh.w2w)
        results.mark_chosen(mesh)
