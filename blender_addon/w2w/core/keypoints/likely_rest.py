# SPDX-License-Identifier: GPL-3.0-or-later
"""The likely rest pose of a skeleton whose file has none: by its own motion, and that of a known rig."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import Body, template
from ..body.skeleton import JOINT_INDEX, JOINT_NAMES
from ..motion.skinning import joint_transforms
from ..motion.source import SourceMotion, unscaled_rotations
from ..retargeting.bone_maps import BoneMap, plain_name
from ..retargeting.repair import flat_footed
from ..retargeting.retarget import matched_joints
from .fit import fit_keypoints
from .joint_sets import JOINT_SETS, JointSet

LIMBS = ("hip", "knee", "shoulder", "elbow")

RESTS: dict[str, dict[str, list[float]]] = template("rest_poses.json")
"""T-poses of rigs whose files may lack it: bone -> turn against a rest pose in which all bones lie along x,
as a rotation vector in degrees, z up and facing -y."""

NEAR = 30.0
"""Degrees by which limbs of a known rest pose may differ from those by the motion, which finds them to 25."""


def with_likely_rest(source: SourceMotion, body: Body, maps: Sequence[BoneMap] = ()) -> SourceMotion:
    """The motion, with the body's T-pose as rest pose if the file's own is not known.

    The joints' positions show how the body's are turned in each frame: by their directions, and the twist of
    limbs by the planes that they bend in. A bone's turn against its joint is the same in all frames, that of
    the rest pose: its mean is taken. The T-pose of a known rig is taken if its limbs are near that. Raises
    UnusableMotion if the skeleton cannot be matched.
    """
    if source.rest_is_known:
        return source
    rig, matched = matched_joints(source, maps)
    joints = _joint_set(matched)
    bones = [matched[JOINT_INDEX[name]] for name in joints.joints]
    with suppress(ValueError):
        fitted = fit_keypoints(source.matrices[:, bones][..., :3, 3], source.rate, joints, body)
        if not fitted.exchanged:
            turns, _ = joint_transforms(body, fitted.motion)
            rest = source.rest.copy()
            for joint, bone in matched.items():
                against = turns[:, joint].swapaxes(1, 2) @ unscaled_rotations(source.matrices[:, bone])
                rest[bone, :3, :3] = _mean(against)
                rest[bone, :3, 3] = body.joints[joint] / fitted.scale
            rest = _of_rig(source, rig, rest, matched)
            return replace(source, rest=flat_footed(replace(source, rest=rest), matched))
    return source


def _of_rig(source: SourceMotion, rig: str, likely: np.ndarray, matched: dict[int, int]) -> np.ndarray:
    """The rest pose of a known rig if its limbs are near the likely ones, else the likely one."""
    turns, rest = RESTS.get(rig, {}), likely.copy()
    for bone, name in enumerate(map(plain_name, source.bones)):
        if name in turns:
            rest[bone, :3, :3] = Rotation.from_rotvec(turns[name], degrees=True).as_matrix()
        if (parent := int(source.parents[bone])) >= 0:
            rest[bone][:3, 3] = (rest[parent] @ np.linalg.solve(source.rest[parent], source.rest[bone]))[
                :3, 3
            ]
    limbs = [matched[joint] for joint, name in enumerate(JOINT_NAMES) if name.endswith(LIMBS)]
    against = likely[limbs][:, :3, :3].swapaxes(1, 2) @ rest[limbs][:, :3, :3]
    is_near = bool((Rotation.from_matrix(against).magnitude() < np.radians(NEAR)).all())
    return rest if turns and is_near else likely


def _joint_set(matched: dict[int, int]) -> JointSet:
    """SMPL's joints, those that have a bone."""
    whole = JOINT_SETS["smpl-24"]
    joints = tuple(name for name in whole.joints if JOINT_INDEX[name] in matched)
    landmarks = {mark: of for mark, of in whole.landmarks.items() if set(of) <= set(joints)}
    return JointSet(whole.name, joints, landmarks)


def _mean(turns: np.ndarray) -> np.ndarray:
    """The rotation (3, 3) nearest to all of some (T, 3, 3)."""
    left, _, right = np.linalg.svd(turns.mean(axis=0))
    return left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
