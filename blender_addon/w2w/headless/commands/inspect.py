# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w inspect`: what a motion file holds, and whether and how it would be used."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ...core.body.body import JOINT_INDEX, Body
from ...core.keypoints.facts import UNITS
from ...core.keypoints.joint_sets import unseen
from ...core.keypoints.pose_files import JointPositions
from ...core.library.import_plan import plan_files
from ...core.library.library import LABELS, Clip, Library, activity_of, read_library
from ...core.motion.motion import Motion
from ...core.motion.skinning import joint_transforms
from ...core.motion.source import SourceMotion, UnusableMotion
from ...core.motion.up import BY_ITSELF
from ...core.readers.animations import animations_in
from ...core.reading.formats import formats_of
from ...core.reading.look import lacking_rests, look_rests, look_up
from ...core.reading.reader import Reader
from ...core.retargeting.bone_maps import BoneMap
from ...core.retargeting.retarget import BY_STRUCTURE
from ...core.study.config import plain
from ...core.windows.windows import WindowSpec
from ...core.wording import clean, join_words
from ..console import NOTHING_TO_DO, USAGE, console_beside, ending, print_json
from ..options import AsJson, PoseOptions, argument, option, with_options
from ..runs.clip_task import Engine
from ..runs.workers import load_alone


@with_options(PoseOptions)
def inspect(
    file: Annotated[Path, argument("FILE", "A motion file: FBX, BVH, AMC, npz, or joints.")],
    library: Annotated[
        Path | None, option("The library that FILE is part of, to see how 'w2w run' labels it.")
    ] = None,
    labels: Annotated[Path | None, option("The csv with its labels, as for 'w2w run'.")] = None,
    bone_map: Annotated[list[Path] | None, option("Bone map of your own rig (JSON).")] = None,
    as_json: AsJson = False,
    *,
    asked: PoseOptions,
) -> None:
    """Say what a motion file holds, and whether and how 'w2w run' would use it.

    Exit codes: 0 it would be used, 1 it would not (and why), 2 wrong use.
    """
    console = console_beside(as_json)
    body = Body.bundled()
    with Reader() as reader:
        with ending(USAGE, console):
            label = label_said(file, library, labels)
            pose = asked.pose()
            bone_maps = tuple(BoneMap.load(path) for path in bone_map or ())
            files, rate = [(clean(file.name), file)], 0.0
            if (found := library_of(file, library, labels)) is not None:
                rate = next((clip.rate for clip in found.clips if clip.path == absolute(file)), 0.0)
            if library is not None and found is not None:
                files = [(clip.file, clip.path) for clip in found.clips]
            if file.is_dir():
                raise ValueError(
                    f"{clean(file)} is a folder: give one of its files, and the folder as --library"
                )
            seen = look_up(reader, files, pose)
            rests = look_rests(reader, lacking_rests(files), body, pose, seen.ups, bone_maps)
        try:
            clip = Clip(file, clean(file.name), "clip", "", rate=rate)
            how = Engine(bone_maps=bone_maps, pose=pose, ups=seen.ups if library else BY_ITSELF, rests=rests)
            source, motion, details = load_alone(clip, body, how, reader)
        except UnusableMotion as error:
            if as_json:
                print_json({"file": str(file), "used": False, "reason": str(error), "label": label})
            raise _skipped(file, str(error), console) from error
    table = Table(show_header=False, box=None, title=clean(file), title_justify="left")
    told: dict[str, str] = {}
    up = f"{pose.up}, as given" if pose.up else seen.sentence() or getattr(source, "up", "")
    animations = [*animations_in(file)]
    stands = [("animations", f"{len(animations)}, each a clip: {quoted(animations)}")] if animations else []
    if source.people > 1 and not isinstance(source, SourceMotion):
        stands.append(("people", f"{source.people}; person {pose.person or 1} is used, 1 being seen longest"))
    stands += [("up", up)] if up else []
    if not (rate or pose.rate) and (says_none := "".join(each.taken_rate for each in formats_of(file))):
        stands.append(("rate", f"taken for granted: {says_none} (--pose-rate gives another)"))
    stands += [("left out", details["cut"])] if "cut" in details else []
    for row in (*_about_source(source, details, body), *stands, *_about_motion(motion, details, body)):
        if not (animations and row[0] == "other takes"):
            table.add_row(*row)
            told[row[0]] = row[1]
    console.print(table)
    reason = too_short(details)
    if as_json:
        about = {"file": str(file), "used": not reason, "reason": reason, "label": label}
        print_json(about | {"said": told, "facts": plain(details)})
    if reason:
        raise _skipped(file, reason, console)
    console.print(Text(f"{clean(file.name)} would be used.", style="green"), label)


def too_short(details: dict[str, Any]) -> str:
    """Why a run would skip a clip that can be read, from the facts of `load_clip`; "" if it would not."""
    shortest = WindowSpec().least_s
    return f"it is shorter than the {shortest:g} s a window needs" if details["duration_s"] < shortest else ""


def _skipped(file: Path, reason: str, console: Console) -> typer.Exit:
    """Say why a run would skip the file; returns the exit to raise."""
    console.print(Text(f"{clean(file.name)} would be skipped:", style="red"), f"{reason.rstrip('.')}.")
    return typer.Exit(NOTHING_TO_DO)


def absolute(file: Path) -> Path:
    """The absolute path of a file; a link keeps its own name."""
    return Path(os.path.abspath(file))  # noqa: PTH100


def library_of(file: Path, library: Path | None, labels: Path | None) -> Library | None:
    """The library that a file is part of, by what is given or a `LABELS` next to it, or None."""
    if library is None and labels is None and not (absolute(file).parent / LABELS).is_file():
        return None
    return read_library(absolute(library or file.parent), labels)


def label_said(file: Path, library: Path | None, labels: Path | None) -> str:
    """A sentence about the label that a run gives the file; a ValueError if it is not in the library."""
    file = absolute(file)
    if (found := library_of(file, library, labels)) is None:
        if animations_in(file):
            activities = [clip.activity for clip in plan_files([file]).clips]
            return f"A run labels its clips {quoted(activities)} after their names."
        inside, above = (activity_of(clean(name)) for name in (file.name, f"{file.parent.name}/{file.name}"))
        if not file.parent.name:
            return f"A run labels it '{inside}' after its file name."
        return (
            f"A run labels it '{above}' after its folder, or '{inside}' after its file name if that folder "
            "is itself the library (see --library)."
        )
    library = absolute(library or file.parent)
    if not file.is_relative_to(library):
        raise ValueError(f"{clean(file)} is not in the library {clean(library)}")
    clips = [clip for clip in found.clips if clip.path == file]
    if not clips:
        inside = clean(file.relative_to(library).as_posix())
        reason = dict(found.skipped).get(inside, "it is not one of the library's motion files")
        return f"But a run on this library would skip it: {reason}."
    source = "its folder" if "/" in clips[0].file else "its file name"
    if clips[0].animation:
        source = "their names"
    if (table := labels or library / LABELS).is_file():
        source = f"its line in {clean(table)}"
    what = "its clips" if clips[0].animation else "it"
    return f"A run labels {what} {quoted([clip.activity for clip in clips])} after {source}."


def quoted(names: Sequence[str]) -> str:
    """Some names in quotation marks."""
    return join_words([f"'{name}'" for name in names], most=12)


def _about_source(
    source: SourceMotion | Motion | JointPositions, details: dict, body: Body
) -> list[tuple[str, str]]:
    rate = f"{details['frames']} at {details['frame_rate']:g} frames/s"
    if isinstance(source, JointPositions):
        return [*_about_joints(source, details, body), ("frames", rate)]
    if not isinstance(source, SourceMotion):
        still = "" if np.ptp(source.pelvis, axis=0).any() else ", in place: the file has no path of the body"
        return [("skeleton", f"SMPL joints{still}"), ("frames", rate)]
    matched = f"matched by their names ({details['skeleton']})"
    if details["skeleton"] == BY_STRUCTURE:
        matched = "matched by structure, as no bone map knows their names"
    bones = source.bones[source.first_bone :]
    rows = [("take", f"'{source.take}'"), ("skeleton", f"{len(bones)} bones, {matched}")]
    if source.other_takes:
        what = f"{len(source.other_takes)} that move are not used"
        rows.append(("other takes", f"{what}: {quoted(source.other_takes)}; save each as a file of its own"))
    if source.people > 1:
        rows.append(("people", f"{source.people}; only one of them is used, the one that moves most"))
    if guess := details.get("rest_guessed"):
        rows.append(("rest pose", f"a guess, {guess}: the file has none that a body can take"))
    extent = np.ptp(source.rest[source.first_bone :, :3, 3], axis=0).max()
    scale = f"1 unit in the file is {details['scale']:.4g} m on W2W's body"
    rows.append(("scale", f"{scale}; the rest pose spans {extent:.4g} units"))
    return [*rows, ("frames", rate)]


def _about_joints(source: JointPositions, details: dict, body: Body) -> list[tuple[str, str]]:
    """Rows about the joints: which there are, which are seldom seen, and what they cannot show."""
    scale = f"1 unit in the file is {details['scale']:.4g} m on W2W's body"
    if source.unit:
        tall = body.height * UNITS[source.unit] / details["scale"]
        scale += f"; in {source.unit} the person is about {tall:.2f} m tall"
    else:
        scale += "; its unit is not known (--pose-unit), which the signals do not need"
    rows = [("joints", source.joint_set.name), ("scale", scale)]
    shares = zip(source.joint_set.joints, np.isfinite(source.positions).all(axis=2).mean(axis=0), strict=True)
    if rare := [f"{name} {share:.0%}" for name, share in shares if share < 0.9]:
        rows.append(("seldom seen", f"share of the frames: {', '.join(rare)}".replace("%", " %")))
    return [*rows, ("not seen", f"{'; '.join(unseen(source.joint_set))}: sensors see none of it here")]


def _about_motion(motion: Motion, details: dict, body: Body) -> list[tuple[str, str]]:
    _, positions = joint_transforms(body, motion)
    across = motion.rotations[:, 0, :2, 0]
    turn = np.degrees(np.ptp(np.unwrap(np.arctan2(across[:, 1], across[:, 0]))[[0, -1]]))
    travel = np.linalg.norm(motion.pelvis[-1, :2] - motion.pelvis[0, :2])
    wrists = positions[:, [JOINT_INDEX["left_wrist"], JOINT_INDEX["right_wrist"]]]
    left, right = np.linalg.norm(np.diff(wrists, axis=0), axis=2).sum(axis=0)
    return [
        ("duration", f"{details['duration_s']:.2f} s"),
        ("body turns", f"{turn:.0f} degrees between the first and last frame"),
        ("body travels", f"{travel:.2f} m between the first and last frame"),
        ("hands travel", f"left {left:.2f} m, right {right:.2f} m along their paths"),
    ]
