# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions into a study's list: files or takes of the scene, retargeted to the body as actions."""

import json
from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path

import bpy

from ...core.body.body import Body
from ...core.files import file_sha256
from ...core.findings.cautions import ODD, cut_sentence
from ...core.keypoints.facts import PoseFacts
from ...core.library.import_plan import ImportPlan, outcome_sentence, taken_before
from ...core.library.labels import speller
from ...core.library.library import Clip
from ...core.motion.sight import Up
from ...core.motion.source import reason_of
from ...core.motion.up import BY_ITSELF, UPSIDE_DOWN, Ups, mostly_head_down
from ...core.reading.clips import How, Rests, RetargetedMotion, fit_clip, open_clip
from ...core.reading.look import lacking_rests, look_rests
from ...core.reading.reader import Reader
from ...core.retargeting.bone_maps import BoneMap
from ...core.wording import clean, free_name
from ...scene.base.actions import write_action
from ...scene.base.body import armature_of, body_of
from ...scene.motion.load import read_by_blender
from ...scene.motion.scene_takes import SceneTake, read_scene_take
from ..jobs import preferences
from ..jobs.jobs import Step, Steps, as_steps, in_thread, on_body, part, pool
from ..study import lists, state
from .patches import get_ready, to_place


@dataclass(frozen=True)
class ImportItem(Clip):
    """A file or a take of the scene to import, and its labels."""

    take: SceneTake | None = None
    up: Up | None = None  # axis of the file that points up, where that is given

    @property
    def called(self) -> str:
        """Its name for people."""
        return self.name if self.take is not None or self.animation else clean(self.path.name)

    @property
    def taken_from(self) -> str:
        """Armature and take that it is from, or "" for a file."""
        return "" if self.take is None else f"{self.take.take.armature.name}|{self.take.name}"


def import_items(plan: ImportPlan, rate: float = 0.0, up: Up | None = None) -> list[ImportItem]:
    """Files that a plan would import, with labels, a frame rate that is not 0, and the axis that is up."""
    return [ImportItem(**vars(clip) | {"rate": clip.rate or rate}, up=up) for clip in plan.clips]


def listed_files(mesh: bpy.types.Object) -> list[Path]:
    """Existing files that clips of the list were read from."""
    files = [Path(clip.file) for clip in mesh.w2w.clips if clip.file and not clip.problem]
    return [file for file in files if file.is_absolute() and file.is_file()]


def map_folder() -> Path:
    """Folder of the user's bone maps; the command line reads the same files by `--bone-map`."""
    return preferences.own_folder("bone_maps")


def saved_maps() -> list[BoneMap]:
    """The user's bone maps; a ValueError names a damaged one."""
    return [BoneMap.load(path) for path in sorted(map_folder().glob("*.json"))]


@on_body
def import_steps(
    mesh: bpy.types.Object,
    items: Sequence[ImportItem],
    left_out: Sequence[tuple[str, str]] = (),
    ups: Ups = BY_ITSELF,
) -> Steps:
    """Import motions one by one; what cannot be used stays in the list and says why, as what is left out.

    The names of the latter come with their reasons. `ups` are the axes that are up in the files together. A
    ValueError refuses motions that hang head down in most frames.
    """
    body, maps = body_of(mesh), saved_maps()
    pool.submit(get_ready, body, to_place(mesh.w2w))  # what fails there fails again where it is asked for
    before, twice = len(mesh.w2w.clips), _listed_already(mesh, items)
    activity = speller(clip.activity for clip in mesh.w2w.clips)
    subject = speller(clip.subject for clip in mesh.w2w.clips)
    items = [replace(item, activity=activity(item.activity), subject=subject(item.subject)) for item in items]
    failed = unlabelled = 0
    down: list[tuple[int, bool]] = []
    cut: list[tuple[str, dict[str, str]]] = []
    files = [(item.called, item.path) for item in items if item.take is None]
    pose = PoseFacts(up=next((item.up for item in items if item.up), None))
    try:
        with Reader() as reader:

            def look(_: object) -> Rests:
                return look_rests(reader, lacking_rests(files), body, pose, ups, maps)

            rests = yield from in_thread(look, "Rest poses", 0.0, 0.0)
            how = How(bone_maps=tuple(maps), pose=pose, ups=ups, rests=rests, blender=read_by_blender)
            for number, item in enumerate(items):
                low, high = number / len(items), (number + 1) / len(items)
                yield Step(low, item.called)
                try:
                    retargeted = yield from part(_retarget(reader, item, body, how), low, high)
                    add_clip(mesh, retargeted, item)
                    if retargeted.cut:
                        cut.append((item.called, {"cut": retargeted.cut}))
                    if item.take is None and item.up is None:
                        down.append((retargeted.motion.n_frames, retargeted.motion.head_down))
                    unlabelled += not item.activity
                except Exception as error:  # even a fault of ours costs this clip alone
                    failed += 1
                    _add_failed(mesh, replace(item, name=item.called), reason_of(error))
        if mostly_head_down(down):
            raise ValueError(f"Nothing is imported: {UPSIDE_DOWN}")
        for name, reason in left_out:
            _add_failed(mesh, ImportItem(Path(), "", name, ""), reason)
    except BaseException:
        remove_clips(mesh, range(before, len(mesh.w2w.clips)))
        raise
    mesh.w2w.clip_index = before
    lists.list_labels(mesh.w2w)
    done = outcome_sentence(len(items) - failed, failed, len(left_out), unlabelled, twice)
    return "; ".join(filter(None, (done, cut_sentence(cut))))


def _retarget(
    reader: Reader, item: ImportItem, body: Body, how: How
) -> Generator[Step, None, RetargetedMotion]:
    """Read a motion and retarget it, in a thread but for takes of the scene."""
    how = replace(how, pose=PoseFacts(up=item.up))
    if item.take is None:
        named = {each.name: getattr(item, each.name) for each in fields(Clip)}
        work = partial(open_clip, Clip(**named), body, how)  # an item would bring the panel to its reader
        return (yield from in_thread(lambda _: reader.read(item.path, work), item.called, 0.0, 1.0))
    # Blender must play it to read it: the window gets its turn after each frame
    source = yield from as_steps(read_scene_take(item.take), item.called, 0.0, 0.8)
    return (yield from in_thread(lambda _: fit_clip(source, item, body, how), item.called, 0.8, 1.0))


def _listed_already(mesh: bpy.types.Object, items: Sequence[ImportItem]) -> list[str]:
    """Names of motions that the list has already, from the same file or a copy of it, or the same take."""
    takes = {clip.taken_from for clip in mesh.w2w.clips} - {""}
    files = taken_before((item.path for item in items if item.take is None), listed_files(mesh))
    return [item.called for item in items if item.taken_from in takes or item.path in files]


def add_clip(mesh: bpy.types.Object, retargeted: RetargetedMotion, item: ImportItem) -> None:
    """Write a motion as an action of the body and list it."""
    name = _free_name(mesh, item.name)
    source = (str(item.path), file_sha256(item.path)) if item.path.name else ("", "")
    clip = mesh.w2w.clips.add()
    clip.name, (clip.file, clip.source_sha256) = name, source
    with state.without_updates():  # they are spelled as others, and listed when all clips are in
        clip.activity, clip.subject = item.activity, item.subject
    clip.motion_key, clip.taken_from, clip.animation = item.motion_key, item.taken_from, item.animation
    clip.given_rate, clip.given_up = item.rate, item.up or retargeted.up_guessed
    set_motion(clip, retargeted)


def set_motion(clip: bpy.types.PropertyGroup, retargeted: RetargetedMotion) -> None:
    """Give a clip of the list its motion, in place of any that it had."""
    armature, before = armature_of(clip.id_data), clip.action
    motion = retargeted.motion.labelled(clip.activity, clip.subject, clip.name)
    with state.without_updates():
        clip.action = write_action(armature, motion, clip.name)
    clip.n_frames, clip.rate = motion.n_frames, motion.rate
    clip.skeleton, clip.scale = retargeted.skeleton, retargeted.scale
    facts = retargeted.facts()
    clip.facts = json.dumps({name: facts[name] for name in ODD & facts.keys()})
    clip.problem = clip.signals = clip.baked_as = clip.bake_path = ""
    if before is not None:
        bpy.data.actions.remove(before)


def remove_clips(mesh: bpy.types.Object, indices: Iterable[int]) -> None:
    """Take clips off the list, with their actions."""
    study = mesh.w2w
    indices = sorted(indices, reverse=True)
    actions = [study.clips[index].action for index in indices]
    for index in indices:
        study.clips.remove(index)
    bpy.data.batch_remove([action for action in actions if action is not None])
    lists.list_labels(study)
    study.clip_index = min(max(study.clip_index, 0), max(len(study.clips) - 1, 0))


def _add_failed(mesh: bpy.types.Object, item: ImportItem, reason: str) -> None:
    name = _free_name(mesh, item.name)
    clip = mesh.w2w.clips.add()
    clip.name, clip.file, clip.problem = name, str(item.path) if item.path.name else "", reason
    clip.given_rate, clip.given_up, clip.animation = item.rate, item.up or "", item.animation


def _free_name(mesh: bpy.types.Object, name: str) -> str:
    """A name that no clip of the list has: clips with the same name would count as one motion."""
    return free_name(name, set(mesh.w2w.clips.keys()), "{} {:03d}", 1)
