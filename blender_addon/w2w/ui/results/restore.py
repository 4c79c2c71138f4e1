# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished run as a study in the panel: from the record in a .blend file, or from a results folder."""

import json
import os
from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import Any

import bpy
import numpy as np

from ...core.body.body import Body
from ...core.findings.cautions import ODD
from ...core.study.clip_files import STORED
from ...core.study.clip_list import CLIP_LIST, Entry, is_used
from ...core.study.config import StudyConfig
from ...core.study.results import StudyResults
from ...core.wording import clean, restated
from ...scene.base.body import armature_of, in_body_space
from ...scene.base.patches import empties_by_patch
from ...scene.files.packing import pack
from ...scene.files.study_file import read_record, remove_record
from ..study import declared, lists, sensors, signal_cache, state
from ..viewport.framing import fold_soon
from ..viewport.legend import show_colours
from . import own_placements, results

KEPT = {*ODD, "source", "cloth_frames"}
"""Facts of a clip that it keeps without a property of its own."""

SUMMARY = "summary.json"
"""File that a results folder is known by."""

GONE = "its motion is no longer where the run left it"
UNHELD = "its motion is not in this file, which holds three an activity: 'Open Results' has all"


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
    check_fits(mesh, run)
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


def check_fits(mesh: bpy.types.Object, run: StudyResults) -> None:
    """Refuse, by a ValueError, a run whose parts do not belong together."""
    patches, utility = run.patches, run.utility
    if len(patches.labels) != len(mesh.data.vertices) or patches.triangles.max() >= len(patches.labels):
        raise ValueError(f"the spots are of another body than '{mesh.name}'")
    if utility.f1.shape != (len(patches), len(utility.activities)):
        raise ValueError(f"the ranking is of other spots than those of '{mesh.name}'")
    with restated("the parameters of the run cannot be understood:", ValueError):
        StudyConfig.from_dict(run.parameters)


def clips_of(
    run: StudyResults, signals: Mapping[str, str], actions: Mapping[str, bpy.types.Action | None]
) -> list[dict[str, Any]]:
    """The clips of a run by the panel's properties, those that could not be used last.

    ValueError if the run's list does not say what is needed of a clip.
    """
    held = {clip: "" if action is not None else GONE for clip, action in actions.items()}
    try:
        used = [
            {
                "action": actions.get(clip.name),  # before its activity, which is noted on it
                **vars(clip),
                "file": _shown_file(entry),
                "n_frames": int(entry["frames"]),
                "rate": float(entry["frame_rate"]),
                "skeleton": str(entry.get("skeleton", "")),
                "scale": float(entry.get("scale", 1.0)),
                "signals": signals.get(clip.name, ""),
                "stored_as": clip.name,
                "problem": held.get(clip.name, UNHELD),
                "source_sha256": str(entry.get("sha256", "")),
                "facts": json.dumps({name: entry[name] for name in KEPT & entry.keys()}),
            }
            for entry, clip in zip(filter(is_used, run.entries), run.clips, strict=True)
        ]
    except KeyError as error:
        reason = f"{run.out}: {CLIP_LIST} does not say {error} of a clip: run the study again"
        raise ValueError(reason) from error
    except (TypeError, ValueError) as error:
        raise ValueError(f"{run.out}: what {CLIP_LIST} says of clips is damaged: {error}") from error
    skipped = [(_shown_file(entry), entry["skipped"]) for entry in run.entries if not is_used(entry)]
    return used + [{"name": clean(Path(file).name), "file": file, "problem": why} for file, why in skipped]


def _shown_file(entry: Entry) -> str:
    """The file of a clip, to show and never to open: the run does not name its library."""
    file = PurePath(entry["file"])
    return file.name if file.is_absolute() else entry["file"]


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


def opened_text(mesh: bpy.types.Object) -> str:
    """Sentences about what was opened and which signals are missing."""
    study = mesh.w2w
    stored = [clip for clip in study.clips if clip.signals.startswith(STORED)]
    text = f"Opened a finished run: {len(stored)} clips on {len(state.patches_of(mesh) or ())} spots"
    lost = [clip for clip in stored if not signal_cache.has(clip)]
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
