# SPDX-License-Identifier: GPL-3.0-or-later
"""Any motion file to a motion on the body, whatever wrote it: the one place where clips are opened."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..body.body import Body
from ..keypoints.facts import PoseFacts
from ..keypoints.fit import UNSMOOTHED_HZ
from ..keypoints.likely_rest import likely_rest
from ..keypoints.pose_files import NO_FACTS, JointPositions
from ..motion.believable import believed, unbroken
from ..motion.motion import Motion
from ..motion.skinning import on_the_ground
from ..motion.source import SourceMotion
from ..motion.up import BY_ITSELF, Ups
from ..retargeting.bone_maps import BoneMap
from ..retargeting.retarget import retarget
from ..wording import count
from .formats import BLENDER_SUFFIXES, Read, Source, read_motion
from .guard import quiet_output


class RetargetedMotion(NamedTuple):
    """A motion without labels on the body, and where it came from.

    `take` is empty for SMPL files; `skeleton` says whose bone names matched, or the joint set; `scale` is
    body metres in one unit of the file; `cut` says which frames at the ends were left out, if any, and
    `up_guessed` which axis of the file is taken as up, if that is assumed, and `rest_guessed` where the
    rest pose comes from, if it is a guess; `people` are in the file, and `head_down` says that this one hangs
    where nobody said which axis is up.
    """

    motion: Motion
    take: str
    skeleton: str
    scale: float
    cut: str
    up_guessed: str = ""
    rest_guessed: str = ""
    people: int = 1
    head_down: bool = False

    def facts(self) -> dict[str, Any]:
        """What a clip's record says of it; what is guessed or cut only if they say something."""
        motion = self.motion
        about = {
            "take": self.take, "skeleton": self.skeleton, "frames": motion.n_frames,
            "frame_rate": motion.rate, "duration_s": round(motion.duration, 4), "scale": self.scale,
        }  # fmt: skip
        some = {
            "cut": self.cut, "up_guessed": self.up_guessed, "rest_guessed": self.rest_guessed,
            "people": self.people if self.people > 1 else 0, "head_down": self.head_down,
        }  # fmt: skip
        return about | {name: value for name, value in some.items() if value}


@dataclass(frozen=True)
class Rests:
    """Guessed rest poses of a library's skeletons whose files have none, one for all clips of a skeleton."""

    poses: tuple[tuple[str, bytes, str], ...] = ()  # `SourceMotion.skeleton`, matrices and origin of each
    files: Mapping[str, str] = field(default_factory=dict, repr=False)  # skeletons by files in the library

    def of_file(self, file: str) -> "Rests":
        """The rest pose of one file's skeleton."""
        if (skeleton := self.files.get(file)) is None:
            return ALONE
        return Rests(tuple(pose for pose in self.poses if pose[0] == skeleton), {file: skeleton})

    def of(self, source: SourceMotion) -> tuple[np.ndarray | None, str]:
        """Rest matrices (B, 4, 4) of a motion's skeleton, and where they come from."""
        for skeleton, pose, origin in self.poses:
            if skeleton == source.skeleton:
                return np.frombuffer(pose).reshape(source.rest.shape), origin
        return None, ""

    def sentence(self) -> str:
        """How many skeletons have a guess, and how many files; "" without any."""
        skeletons, files = (
            count(what, len(of)) for what, of in (("skeleton", self.poses), ("file", self.files))
        )
        return f"one guess for each of {skeletons} without one, in {files}" if self.poses else ""


ALONE = Rests()
"""The `Rests` for a file that is part of no library."""

ITS_OWN = "from its own motion"


@dataclass(frozen=True, kw_only=True)
class How:
    """How clips are read: what is known of all, and what their library's files tell together.

    `bone_maps` are the user's own, tried before the bundled ones; `ups` are the axes that are up in the
    files, `rests` the rest poses of their skeletons; `blender` reads what its importers do.
    """

    bone_maps: tuple[BoneMap, ...] = ()
    pose: PoseFacts = NO_FACTS
    ups: Ups = BY_ITSELF
    rests: Rests = ALONE
    blender: Read | None = None


@dataclass(frozen=True)
class Clip:
    """A motion file and its labels, "" if unknown."""

    path: Path
    file: str  # its path inside the library with forward slashes, as text to show; an animation's is below it
    name: str  # for files made from it: safe on every file system and unique in the library
    activity: str
    subject: str = ""  # who moves
    motion_key: str = ""  # clips with an equal key show the same recording
    source: str = ""  # the data set or system that it is from
    animation: str = ""  # the one that it is, of a file that holds several
    rate: float = 0.0  # frames per second, whatever the file says; 0 where its own is right

    @property
    def needs_blender(self) -> bool:
        """Whether Blender's importers read the file."""
        return self.path.suffix.lower() in BLENDER_SUFFIXES


def read_clip(clip: Clip, how: How) -> Source:
    """What a clip's file holds; `UnusableMotion` if it cannot be used."""
    with quiet_output():
        return read_motion(clip.path, how.pose.at(clip.rate), how.ups, clip.animation, how.blender)


def fit_clip(source: Source, clip: Clip, body: Body, how: How) -> RetargetedMotion:
    """A clip's motion on a body under its labels; without a name it keeps those that its file holds."""
    found = to_body(source, body, how.bone_maps, how.rests)
    motion = found.motion.labelled(clip.activity, clip.subject, clip.name) if clip.name else found.motion
    hangs = found.motion.head_down and how.pose.up is None
    return found._replace(motion=motion, people=source.people, head_down=hangs)


def open_clip(clip: Clip, body: Body, how: How) -> RetargetedMotion:
    """Read a clip and retarget it to a body; `UnusableMotion` if it cannot be used."""
    return fit_clip(read_clip(clip, how), clip, body, how)


def to_body(
    source: Source, body: Body, maps: Sequence[BoneMap] = (), rests: Rests = ALONE
) -> RetargetedMotion:
    """Retarget what a file holds to a body; the user's own bone maps are tried before the bundled ones.

    `rests` are the rest poses of its library's skeletons. Rest poses and damage at the ends are left out.
    Raises `UnusableMotion` if the skeleton cannot be matched, the joints make no body, or no body moves so.
    """
    if isinstance(source, JointPositions):
        part, cut = unbroken(body, source.fit(body, UNSMOOTHED_HZ).motion)
        fit = replace(source, positions=source.positions[part]).fit(body)
        kept = believed(body, fit.motion, None, part.start, cut, path_apart=False)
        name = source.joint_set.name
        return RetargetedMotion(kept.motion, "", name, fit.scale, kept.cut, source.up_guessed)
    if isinstance(source, Motion):
        kept = believed(body, on_the_ground(body, source))
        return RetargetedMotion(kept.motion, "", "SMPL", 1.0, kept.cut, source.up_guessed)
    rested, origin = with_likely_rest(source, body, maps, rests)
    found = retarget(rested, body, maps)
    kept = believed(body, found.motion, found.rest, source.first_frame, source.cut, found.path)
    about = (source.take, found.bone_map, found.scale, kept.cut, source.up_guessed, origin)
    return RetargetedMotion(kept.motion, *about)


def with_likely_rest(
    source: SourceMotion, body: Body, maps: Sequence[BoneMap] = (), rests: Rests = ALONE
) -> tuple[SourceMotion, str]:
    """The motion, with a likely rest pose if the file's own is not known, and where that comes from, else "".

    It is its skeleton's in the library, else the body's T-pose by the clip itself. Raises UnusableMotion if
    the skeleton cannot be matched.
    """
    if source.rest_is_known:
        return source, ""
    rest, origin = rests.of(source)
    if rest is None:
        rest, origin = likely_rest([source], body, maps), ITS_OWN
    return source if rest is None else replace(source, rest=rest), origin
