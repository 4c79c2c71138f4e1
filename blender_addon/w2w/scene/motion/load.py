# SPDX-License-Identifier: GPL-3.0-or-later
"""Any motion file to a motion on the body, whatever wrote it."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from ...core.body.body import Body
from ...core.keypoints.facts import PoseFacts
from ...core.keypoints.pose_files import NO_FACTS, JointPositions, read_joints
from ...core.library.library import is_joint_file
from ...core.motion.motion import SMPL_SUFFIXES, Motion, read_amass
from ...core.motion.skinning import on_the_ground
from ...core.motion.source import SourceMotion
from ...core.readers.asf_amc import AMC_SUFFIX, read_amc
from ...core.readers.bvh import BVH_SUFFIX, read_bvh
from ...core.readers.mvnx import MVNX_SUFFIX, read_mvnx
from ...core.retargeting.bone_maps import BoneMap
from ...core.retargeting.retarget import retarget


class Carried(NamedTuple):
    """A motion without labels on the body, and where it came from.

    `take` is empty for SMPL files; `skeleton` says whose bone names matched, or the joint set; `scale` is
    body metres in one unit of the file.
    """

    motion: Motion
    take: str
    skeleton: str
    scale: float


Source = SourceMotion | Motion | JointPositions
"""What a motion file may hold."""

READERS: dict[str, Callable[[Path, float | None], Source]] = {
    AMC_SUFFIX: read_amc,
    BVH_SUFFIX: read_bvh,
    MVNX_SUFFIX: read_mvnx,
    **dict.fromkeys(SMPL_SUFFIXES, read_amass),
}
"""Readers by the suffix of the file; a frame rate that is given goes before the file's own."""


def read_motion(path: Path, pose: PoseFacts = NO_FACTS) -> Source:
    """Read a motion file: FBX, glTF and USD through Blender, all else directly.

    `pose` says what is known of joint positions, where the file holds those, and the frame rate of any file,
    whatever it says itself. Raises `UnusableMotion` if it cannot be used.
    """
    if is_joint_file(path):
        return read_joints(path, pose)
    kind = path.suffix.lower()
    if kind in READERS:
        return READERS[kind](path, pose.rate)
    from .takes import read_clip

    return read_clip(path, pose.rate)


def carry(source: Source, body: Body, maps: Sequence[BoneMap] = ()) -> Carried:
    """Retarget what a file holds to a body; the user's own bone maps are tried before the bundled ones.

    Raises `UnusableMotion` if the skeleton cannot be matched, or the joints make no body.
    """
    if isinstance(source, JointPositions):
        found = source.fit(body)
        return Carried(found.motion, "", source.joint_set.name, found.scale)
    if isinstance(source, Motion):
        return Carried(on_the_ground(body, source), "", "SMPL", 1.0)
    carried = retarget(source, body, maps)
    return Carried(carried.motion, source.take, carried.bone_map, carried.scale)
