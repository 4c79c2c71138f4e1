# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs that bake the signals of a study's clips and rank patches by them."""

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from operator import attrgetter

import bpy
import numpy as np
from bpy.props import EnumProperty

from ...core.body.regions import regions_of
from ...core.findings.in_words import baked_sentence
from ...core.imu.recording import ImuRecording
from ...core.imu.virtual import at_patches
from ...core.motion.signature import motion_signature
from ...core.motion.source import reason_of
from ...core.study.choosing import Choices, rank_files
from ...core.study.clip_files import write_clip
from ...core.study.ranking import LabelledClip
from ...core.study.results import HeldResults
from ...core.study.signals import describe, record_baked
from ...core.wording import join_words
from ...scene.bake import PatchBaker
from ...scene.files.study_file import pack
from ..jobs.jobs import Step, Steps, as_steps, in_thread, is_there, on_body, part
from ..jobs.preferences import SIGNALS_SUFFIX, cache_folder
from ..results import results
from ..study import covers, operators, signal_cache, state
from ..viewport.legend import show_colours

OF_SIGNALS = {"at_full_scale", "cloth_caught", "cloth_frames"}
"""Facts of a clip that a bake finds."""

UNBAKED = "cannot be baked"
"""Prefix of `bake_path` for clips that failed to bake."""


@on_body
def bake_steps(mesh: bpy.types.Object, indices: Sequence[int], keep: bool = False) -> Steps:
    """Bake clips of a body: the surface through Blender, the signals in a thread.

    A clip that cannot be baked gets no signals and its `bake_path` says why. With `keep`, clips stay baked
    if the job is stopped before the last.
    """
    if not indices:
        return "All signals are up to date"
    study, patches = mesh.w2w, state.placed_patches(mesh)
    baked = attrgetter("signals", "baked_as", "bake_path")
    before = {index: baked(study.clips[index]) for index in indices}
    bakers, failed = {0: (yield from covers.baker_steps(mesh, patches))}, []
    try:
        for number, index in enumerate(indices):
            name = study.clips[index].name
            yield Step(number / len(indices), name)
            try:
                clip = study.clips[index]
                first = state.kept_patches(study, clip) if signal_cache.has(clip) else 0
                if first not in bakers:  # only patches that were added
                    added = at_patches(patches, list(range(first, len(patches))))
                    bakers[first] = PatchBaker(mesh, replace(added, own_names=patches.names[first:]))
                steps = _bake_clip(mesh, bakers[first], first, index)
                yield from part(steps, number / len(indices), (number + 1) / len(indices))
            except Exception as error:  # even a fault of ours costs this clip alone
                reason = reason_of(error)
                failed.append(f"{name} ({reason})")
                _set_signals(mesh.w2w.clips[index], "", "", f"{UNBAKED}: {reason}")
        if len(failed) == len(indices) and not keep:
            raise ValueError(f"No clip could be baked: {join_words(failed, 2)}")
    except BaseException:
        if not keep and is_there(mesh):
            for index, values in before.items():
                _set_signals(mesh.w2w.clips[index], *values)
        raise
    paths = {study.clips[index].name: study.clips[index].bake_path for index in indices}
    return baked_sentence(paths, len(patches), failed)


def _bake_clip(mesh: bpy.types.Object, baker: covers.Baker, first: int, index: int) -> Steps:
    """Bake one clip from the baker's `first` patch on: its signals and features into the cache."""
    study, folder = mesh.w2w, cache_folder()
    settings, config = state.bake_settings(study), state.config_of(study)
    clip = study.clips[index]
    name, labels = clip.name, (clip.activity, clip.subject, clip.name)
    place, names = signal_cache.place_of(clip), state.placed_patches(mesh).names
    bake = yield from as_steps(baker.by_frame(clip.action), f"{name}, evaluated by Blender", 0.0, 0.8)

    def work(progress: Callable[[float], None]) -> str:
        baked = range(first, first + len(baker.patches))
        recording = record_baked(
            bake.matrices, bake.rate, baker.patches, labels, config, bake.root, bake.on_cloth, baked
        )
        progress(0.5)
        windows = describe(recording, config)
        if first:
            recording, windows = signal_cache.with_added(place, recording, windows)
            recording = recording.labelled(names, *labels)
        key = _key(recording, windows[0], settings)
        # an action that is not a plain Motion has no signature, so it never counts as a copy
        signature = np.empty(0) if bake.motion is None else motion_signature(bake.motion)
        write_clip(folder, key + SIGNALS_SUFFIX, recording, windows, signature)
        facts.update(config.sensor_model().full_scale_content(recording))
        return key

    facts = {name: value for name, value in json.loads(clip.facts or "{}").items() if name not in OF_SIGNALS}
    if bake.on_cloth is not None:
        facts |= bake.on_cloth.facts()
    key = yield from in_thread(work, name, 0.8, 1.0)
    mesh.w2w.clips[index].facts = json.dumps(facts)
    _set_signals(mesh.w2w.clips[index], key, settings, f"{bake.path} path: {bake.reason}")
    return name


@on_body
def rank_steps(mesh: bpy.types.Object) -> Steps:
    """Rank every patch, after baking again what the cache has lost."""
    study = mesh.w2w
    if problem := state.labels_problem(ranked_clips(study)):
        unbaked = [clip for clip in state.usable(study) if clip.bake_path.startswith(UNBAKED)]
        raise ValueError(f"{unbaked[0].name} {unbaked[0].bake_path}" if unbaked else problem)
    lost = [study.clips.find(clip.name) for clip in ranked_clips(study) if not signal_cache.has(clip)]
    if lost:
        yield from part(bake_steps(mesh, lost), 0.0, 0.4)
    ranked_as, config = state.rank_settings(study), state.config_of(study)
    used = [as_labelled(clip) for clip in ranked_clips(study)]
    places = signal_cache.places_of(ranked_clips(study))
    body, patches = state.body_as_run(mesh), state.placed_patches(mesh)

    def rank(progress: Callable[[float], None]) -> Choices[HeldResults]:
        ranked = rank_files(used, places, patches, body, config, progress)
        pack(ranked.study.utility)  # kept, as the regions are: here they stop no window
        regions_of(body)
        return ranked

    ranked = yield from in_thread(rank, "training at every spot", 0.4 if lost else 0.0, 0.95)
    yield Step(0.95, "painting heatmaps")
    utility = ranked.study.utility
    results.store(mesh, utility, ranked_as, ranked.study.clips)
    known[:] = [(known_by(study, places), ranked)]
    show_colours()
    return f"Ranked {len(patches)} spots, {utility.protocol}"


known: list[tuple[object, Choices[HeldResults]]] = []
"""The study that was ranked or chosen in last, by what it depends on."""


def known_by(study: bpy.types.PropertyGroup, places: Sequence[object]) -> object:
    """What a ranking of clips, whose files lie at some places, depends on, but for weights."""
    return study.ranked_as, study.utility_key, *places


def ranked_clips(study: bpy.types.PropertyGroup) -> list[bpy.types.PropertyGroup]:
    """The clips that a ranking is made of: baked, and with an activity."""
    return [clip for clip in state.baked(study) if clip.activity.strip()]


def as_labelled(clip: bpy.types.PropertyGroup) -> LabelledClip:
    """A clip as `LabelledClip`."""
    return LabelledClip(clip.name, clip.activity, clip.subject, clip.motion_key)


def to_bake(study: bpy.types.PropertyGroup) -> list[int]:
    """Numbers of the clips whose signals are missing or out of date."""
    fresh = {clip.name for clip in state.baked(study) if signal_cache.has(clip)}
    return [study.clips.find(clip.name) for clip in state.usable(study) if clip.name not in fresh]


def _key(recording: ImuRecording, features: np.ndarray, settings: str) -> str:
    """Key of baked signals: the same content has the same key in every study."""
    digest = hashlib.sha256(settings.encode())
    for array in (recording.acc, recording.gyr, *recording.further.values(), features):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:32]


def _set_signals(clip: bpy.types.PropertyGroup, key: str, settings: str, path: str) -> None:
    clip.signals, clip.baked_as, clip.bake_path = key, settings, path


class W2W_OT_bake_signals(operators.JobOperator, bpy.types.Operator):
    """Simulate accelerometers and gyroscopes on all spots; Esc cancels"""

    which: EnumProperty(
        name="Which",
        items=(
            ("ALL", "All", "Bake every clip whose signals are missing or out of date"),
            ("TICKED", "Ticked", "Bake the ticked clips, or the active one, even if they are up to date"),
        ),
    )

    missing = staticmethod(lambda _context, body: state.missing_for_bake(body))

    def steps(self, body: bpy.types.Object) -> Steps:
        study = body.w2w
        if self.which == "ALL":
            return bake_steps(body, to_bake(study))
        ticked = [clip.name for clip in state.selected(study) if clip.action]
        return bake_steps(body, [study.clips.find(name) for name in ticked])


class W2W_OT_rank_patches(operators.JobOperator, bpy.types.Operator):
    """Train and test a classifier at every spot, and show where it recognises activities best"""

    bl_label = "Score Spots"
    missing = staticmethod(lambda _context, body: state.missing_for_rank(body))
    steps = staticmethod(rank_steps)
