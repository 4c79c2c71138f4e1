# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished run as a study in the panel: from the record in a .blend file, or from a results folder."""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...core.body.body import Body
from ...core.findings.listed import clips_of
from ...core.study.clip_files import STORED
from ...core.study.config import StudyConfig
from ...core.study.results import StudyResults
from ...scene.base.body import armature_of, in_body_space
from ...scene.base.patches import empties_by_patch
from ...scene.files.study_file import pack, read_record, remove_record
from ..study import declared, lists, sensors, signal_cache, state
from ..viewport.framing import fold_soon
from ..viewport.legend import show_colours
from . import own_placements, results

SUMMARY = "summary.json"
"""File that a results folder is known by."""


def restore(mesh: bpy.types.Object) -> str:
    """Make a study of the record stored with a mesh; returns what was found.

    ValueError if the record is damaged or not of this mesh; nothing has been changed then.
    """
    run, names = read_record(mesh)
    placed, chosen = (bpy.data.collections.get(name) for name in names.collections)
    found = empties_by_patch(placed) if placed is not None else {}
    empties = list(found.values())
    if not empties or max(found) >= len(run.patches) or any(item.parent is not mesh for item in empties):
        raise ValueError(f"the spots of '{mesh.name}' are no longer in the file as the run left them")
    run.check_fits(mesh.name, len(mesh.data.vertices))
    actions = {clip: bpy.data.actions.get(action) for clip, action in names.actions.items()}
    clips = clips_of(run, names.signals, actions)
    study = mesh.w2w
    study.patch_size = empties[0].empty_display_size
    study.patch_collection, study.chosen_collection = placed, chosen
    for empty in empties:  # without W2W their names are the only marks; the panel has its own
        empty.show_name = empty.show_in_front = False
        empty.select_set(False)
    study.results_near = os.curdir
    fill(mesh, run, clips)
    remove_record(mesh)
    fold_soon()
    return opened_text(mesh)


def fill(mesh: bpy.types.Object, run: StudyResults, clips: list[dict[str, Any]]) -> None:
    """Give a body that has its patches everything else that a run found; `clips` as `clips_of` gives them."""
    study, config = mesh.w2w, run.config()
    body, own = in_body_space(mesh, armature_of(mesh)), Body.bundled().vertices
    study.is_body = True
    study.has_shape = body.shape == own.shape and np.allclose(body, own, atol=1e-6)  # as the sliders start
    study.parameters = json.dumps(run.parameters)
    lists.list_wishes(study, config.constraints)
    study.patches_text, study.patches_key = pack(run.patches)
    own_placements.keep_placed(study, run.patches, config)
    _set_parameters(study, config)
    study.clips.clear()
    settings = state.bake_settings(study)
    with state.without_updates():
        for values in clips:
            clip = study.clips.add()
            for name, value in values.items():
                setattr(clip, name, value)
            clip.baked_as = settings if clip.signals else ""
    results.store(mesh, run.utility, state.rank_settings(study), run.clips)
    content = {name: run.summary.get(name) for name in ("worn_together", "cards", "pilot")}
    _advise(mesh, content)
    show_colours()
    find_folder(study)


def find_folder(study: bpy.types.PropertyGroup) -> None:
    """Look for the results folder that has a study's signals: near the .blend file, else at its old place."""
    folders = [Path(study.results_folder)] if study.results_folder else []
    if study.results_near and bpy.data.filepath:
        folders.insert(0, (Path(bpy.data.filepath).parent / study.results_near).resolve())
    found = (str(folder) for folder in folders if (folder / SUMMARY).is_file())
    study.results_folder = next(found, study.results_folder)


def opened_text(mesh: bpy.types.Object, seen: bool = False) -> str:
    """Sentences about what was opened and which signals are missing, none if all were `seen` just now."""
    study = mesh.w2w
    stored = [clip for clip in study.clips if clip.signals.startswith(STORED)]
    text = f"Opened a finished run: {len(stored)} clips on {len(state.patches_of(mesh) or ())} spots"
    lost = [] if seen else [clip for clip in stored if not signal_cache.has(clip)]
    if not lost:
        return text
    where = f"in {study.results_folder}" if study.results_folder else "next to this file"
    hint = "locate the results folder, or bake them again (page Details)"
    return f"{text}. The signals of {len(lost)} clips are not {where}: {hint}"


def _set_parameters(study: bpy.types.PropertyGroup, config: StudyConfig) -> None:
    with state.without_updates():
        declared.show_config(study, config)
        study.patch_seed, study.window_s = config.seed, config.windows.length_s
        study.placed_as = state.placing_of(study)
        if config.own_sensor is not None and config.own_sensor.name == config.sensor:
            sensors.keep_own_sensor(study, config.own_sensor)
            study.sensor = sensors.OWN
        else:
            study.sensor = config.sensor
        study.record, study.recognise_by = set(config.further.record), set(config.further.features)
        study.magnetic_dip = config.further.dip_deg


def _advise(mesh: bpy.types.Object, content: Mapping[str, Any]) -> None:
    """Show the run's sets; what cannot be understood is to be chosen again."""
    try:
        lists.keep_advice(mesh.w2w, content)
        known = range(len(state.patches_of(mesh) or ()))
        whole = all(row.patch in known for row in mesh.w2w.worn)
    except (KeyError, TypeError, ValueError):
        whole = False
    if not whole:
        lists.forget_advice(mesh.w2w)
    results.mark_chosen(mesh)
