# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W from Python: bodies and motions from files."""

import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ..core.body.body import Body
from ..core.findings.notes import merged_sentence
from ..core.given import Clips, given_numbers, given_path
from ..core.keypoints.facts import PoseFacts
from ..core.keypoints.naming import RawPose
from ..core.keypoints.pose_files import NO_FACTS, JointPositions, joints_of
from ..core.library.import_plan import plan_files
from ..core.library.labels import LabelCheck
from ..core.library.library import Clip, activity_of, read_library
from ..core.motion.motion import Motion, smpl_motion
from ..core.motion.source import UnusableMotion, reason_of
from ..core.motion.up import UPSIDE_DOWN, mostly_head_down
from ..core.readers.animations import animations_in
from ..core.reading.clips import How, open_clip, to_body
from ..core.reading.guard import quiet_output
from ..core.reading.look import lacking_rests, look_rests, look_up
from ..core.reading.reader import Reader
from ..core.retargeting.bone_maps import BoneMap
from ..core.wording import in_python, restated
from ..scene.motion.load import read_by_blender
from .notebook import tracked

NO_BLENDER = (
    "is read through Blender's Python module, which is missing: in W2W's folder, with Python 3.11, run "
    "pip install '.[blender]'"
)


@dataclass(frozen=True, eq=False)
class Motions(Clips[Motion]):
    """Motions on one body."""

    motions: tuple[Motion, ...]
    body: Body
    skipped: tuple[tuple[str, str], ...] = ()
    """Files that could not be used, each with the reason."""
    motion_keys: tuple[str, ...] = ()
    """Keys as in a labels file: equal ones mark one recorded motion; "" if unknown."""
    facts: tuple[dict[str, Any], ...] = ()
    """What was found in each file: skeleton, scale, frames cut at the ends."""
    of_clips = ("motions", "motion_keys", "facts")

    def __repr__(self) -> str:
        activities = {motion.activity for motion in self.motions}
        return f"<Motions: {len(self)} of {len(activities)} activities, {len(self.skipped)} files skipped>"


def load_body(path: str | Path, betas: Sequence[float] | None = None) -> Body:
    """Read a body: W2W's own npz, or an SMPL model or mesh as `w2w run --bodies` takes.

    Parameters
    ----------
    path : str or Path
    betas : sequence of float, optional
        Shape of an SMPL model.

    Returns
    -------
    Body
        The body in its rest pose, in Blender's world.

    Raises
    ------
    ValueError
        If W2W cannot use the body; the message says why.
    ModuleNotFoundError
        If reading it needs Blender's Python module, which is missing.

    Examples
    --------
    >>> w2w.Body.bundled().save("body.npz")
    >>> w2w.load_body("body.npz")
    <Body 'neutral': 1.73 m, 6890 vertices>
    """
    path = given_path(path, "a body")
    if path.suffix.lower() == ".npz" and betas is None:
        with suppress(ValueError):  # an SMPL model is an npz too
            return Body.load(path)
    numbers = None if betas is None else given_numbers(betas, "betas")
    with (
        Reader() as reader,
        restated(f"{path.name} {NO_BLENDER}", ModuleNotFoundError),
        restated(f"{path}:", UnusableMotion),
    ):
        return reader.read(path, partial(adopted, path, numbers))


def adopted(path: Path, betas: np.ndarray | None) -> Body:
    """A body from a file, by the Blender of this process."""
    with quiet_output():
        from ..scene.body.adopt import adopt_file

        return adopt_file(path, betas)


def load(
    path: str | Path,
    body: Body | None = None,
    labels: str | Path | None = None,
    bone_maps: Sequence[BoneMap] = (),
    pose: PoseFacts = NO_FACTS,
) -> Motions:
    """Read motion files and retarget them to a body.

    FBX, glTF and USD are read through Blender's Python module (`bpy`), all else without it.

    Parameters
    ----------
    path : str or Path
        A folder of motion files, searched with its subfolders, or one file.
    body : Body, optional
        W2W's own by default.
    labels : str or Path, optional
        A csv with the columns ``file,activity`` and if wanted ``subject``, ``motion_key`` and ``rate``,
        frames a second that go before a file's own and `pose`. By default the labels come from
        ``labels.csv`` in the folder, else from the names of the subfolders, else from the file names, as with
        `w2w run`. One npz that `Motion.save` wrote keeps the labels that it holds.
    bone_maps : sequence of BoneMap
        Your own, tried before the bundled ones.
    pose : PoseFacts
        Unit and joint set of joint positions, if the files lack them; frame rate and axis that is up
        of all files, whatever they say. By default one axis is up in all of a folder's files of a kind.

    Returns
    -------
    Motions
        A sequence of `Motion`; ``skipped`` lists the files that cannot be used and why.

    Raises
    ------
    ValueError
        If no file can be used; the message says why.

    Warns
    -----
    UserWarning
        If labels that differ only in case, blanks or the like count as one.

    Examples
    --------
    >>> motions = w2w.load("MY_CLIPS", labels="labels.csv")
    >>> motions[0].activity, motions[0].subject
    ('kicking', 'person 0')
    """
    body = _checked(body)
    if not isinstance(pose, PoseFacts):
        raise ValueError(f"pose must be PoseFacts, such as PoseFacts(rate=30), not {pose!r}")
    if not isinstance(bone_maps, Sequence) or any(not isinstance(one, BoneMap) for one in bone_maps):
        raise ValueError("bone_maps is a list of BoneMap")
    path = given_path(path, "a folder of motion files, or one file,")
    labels = labels if labels is None else given_path(labels, "a csv of labels")
    if path.is_file() and labels is not None:
        raise ValueError("labels are for the files in a folder: give the folder")
    how = How(bone_maps=tuple(bone_maps), pose=pose, blender=read_by_blender)
    if path.is_file() and not animations_in(path):
        with Reader() as reader:
            motion, about = _read(reader, Clip(path, path.name, "", ""), body, how)
        _refuse_head_down([motion], pose)
        if not motion.activity:
            motion = motion.labelled(activity_of(path.name), motion.subject, motion.clip or path.stem)
        return Motions((motion,), body, (), ("",), (about,))
    if path.is_file():  # each of its animations is a clip
        plan = plan_files([path])
        clips, skipped = plan.clips, list(plan.left_out)
    else:
        library = read_library(path, labels)
        clips, skipped = library.clips, list(library.skipped)
        warn_of_spellings(library.check)
    motions, keys, facts = [], [], []
    with Reader() as reader:
        files = [(clip.file, clip.path) for clip in clips]
        if (seen := look_up(reader, files, pose)).question:
            raise ValueError(in_python(seen.question))
        rests = look_rests(reader, lacking_rests(files), body, pose, seen.ups, bone_maps)
        how = replace(how, ups=seen.ups, rests=rests)
        for clip in tracked(clips, "Reading motions"):
            try:
                motion, about = _read(reader, clip, body, how)
            except ValueError as error:
                skipped.append((clip.file, str(error)))
                continue
            motions.append(motion)
            keys.append(clip.motion_key)
            facts.append(about | {"file": clip.file, "source": clip.source})
    if not motions:
        file, reason = skipped[0]
        raise ValueError(f"no motion in {path} can be used; {file}: {reason}")
    _refuse_head_down(motions, pose)
    return Motions(tuple(motions), body, tuple(skipped), tuple(keys), tuple(facts))


def from_joints(positions: np.ndarray, pose: PoseFacts, body: Body | None = None) -> Motion:
    """Make a motion from joint positions in memory, as from a pose estimator.

    Parameters
    ----------
    positions : ndarray, shape (T, J, 3) or (P, T, J, 3)
        Positions in any unit; NaN where a joint was not seen. Of P people ``pose.person`` is taken.
    pose : PoseFacts
        Frame rate, and where the number of joints leaves it open the joint set; the axis that is up.
    body : Body, optional
        W2W's own by default.

    Returns
    -------
    Motion
        Without labels: `labelled` gives it an activity, a subject and a clip's name.

    Raises
    ------
    ValueError
        If the positions make no body, or the facts do not fit; the message says why.

    Examples
    --------
    >>> joints = w2w.Body.bundled().joints + 0.02 * np.sin(np.arange(60) / 5)[:, None, None]  # z is up
    >>> w2w.from_joints(joints, w2w.PoseFacts(rate=30, up="z")).labelled("swaying", "Ada", "one")
    <Motion 'one', 'swaying': 60 frames at 30 Hz>
    """
    if not isinstance(pose, PoseFacts):
        raise ValueError(f"pose must be PoseFacts, such as PoseFacts(rate=30), not {pose!r}")
    raw = RawPose(given_numbers(positions, "positions").copy(), (), NO_FACTS)
    return _on_body(lambda: joints_of(raw, pose), _checked(body))


def from_smpl(
    poses: np.ndarray,
    trans: np.ndarray,
    rate: float,
    up: Literal["x", "y", "z", "-x", "-y", "-z"] | None = None,
    body: Body | None = None,
) -> Motion:
    """Make a motion from SMPL parameters in memory.

    Parameters
    ----------
    poses : ndarray, shape (T, 72), (T, 156), (T, 165) or (T, 66)
        Axis-angle of SMPL, SMPL-H or SMPL-X, radians.
    trans : ndarray, shape (T, 3)
        Path, metres.
    rate : float
        Frames per second.
    up : {"x", "y", "z", "-x", "-y", "-z"}, optional
        Axis that is up; by default as people stand.
    body : Body, optional
        W2W's own by default.

    Returns
    -------
    Motion
        Without labels: `labelled` gives it an activity, a subject and a clip's name.

    Raises
    ------
    ValueError
        If they are no motion, or no body moves so; the message says why.

    Examples
    --------
    >>> poses = np.zeros((60, 72))
    >>> poses[:, 48] = np.sin(np.arange(60) / 5)  # the left upper arm
    >>> w2w.from_smpl(poses, np.zeros((60, 3)), rate=30, up="y")
    <Motion '', '': 60 frames at 30 Hz>
    """
    facts = PoseFacts(rate=rate, up=up)
    if facts.rate is None:
        raise ValueError("rate is the frames per second: SMPL parameters do not say it")
    arrays = given_numbers(poses, "poses"), given_numbers(trans, "trans")
    return _on_body(lambda: smpl_motion(*arrays, rate, up), _checked(body))


def _on_body(make: Callable[[], JointPositions | Motion], body: Body) -> Motion:
    """A motion in memory, on a body."""
    with restated(lambda error: in_python(str(error)), (UnusableMotion, ValueError)):
        return to_body(make(), body).motion


def _checked(body: Body | None) -> Body:
    """The body, W2W's own by default; a ValueError for anything else."""
    if not isinstance(body, Body | None):
        raise ValueError(f"body must be a Body, from load_body or shaped, not {body!r}")
    return Body.bundled() if body is None else body


def _refuse_head_down(motions: Sequence[Motion], pose: PoseFacts) -> None:
    """Refuse motions that hang head down in most frames, by a ValueError; some handstands are motions."""
    if pose.up is None and mostly_head_down((motion.n_frames, motion.head_down) for motion in motions):
        raise ValueError(in_python(UPSIDE_DOWN))


def warn_of_spellings(check: LabelCheck) -> None:
    """Warn the caller's caller of labels that were spelled in several ways and count as one."""
    sentences = [merged_sentence(name, ways) for name, ways in check.spellings]
    sentences += [merged_sentence(name, ways, "subject") for name, ways in check.subjects]
    if sentences:
        warnings.warn("; ".join(sentences), stacklevel=3)


def _read(reader: Reader, clip: Clip, body: Body, how: How) -> tuple[Motion, dict[str, Any]]:
    """Read a motion onto the body, with facts, or raise a ValueError."""
    try:
        with restated(f"{clip.path.name} {NO_BLENDER}", ModuleNotFoundError):
            found = reader.read(clip.path, partial(open_clip, clip, body, how))
    except Exception as error:  # even a fault of ours costs this file alone
        raise ValueError(in_python(reason_of(error))) from error
    return found.motion, found.facts()
