# SPDX-License-Identifier: GPL-3.0-or-later
"""The likely rest pose of a skeleton whose file has none: by its own motion."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from ..body.body import Body
from ..body.skeleton import JOINT_INDEX
from ..motion.skinning import joint_transforms
from ..motion.source import SourceMotion, unscaled_rotations
from ..retargeting.bone_maps import BoneMap
from ..retargeting.repair import flat_footed
from ..retargeting.retarget import matched_joints
from .fit import fit_keypoints
from .joint_sets import JOINT_SETS, JointSet


def with_likely_rest(source: SourceMotion, body: Body, maps: Sequence[BoneMap] = ()) -> SourceMotion:
    """The motion, with the body's T-pose as rest pose if the file's own is not known.

    The joints' positions show how the body's are turned in each frame: by their directions, and the twist of
    limbs by the planes that they bend in. A bone's turn against its joint is the same in all frames, that of
    the rest pose: its mean is taken. Raises UnusableMotion if the skeleton cannot be matched.
    """
    if source.rest_is_known:
        return source
    matched = matched_joints(source, maps)[1]
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
            return replace(source, rest=flat_footed(replace(source, rest=rest), matched))
    return source


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
