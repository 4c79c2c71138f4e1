# SPDX-License-Identifier: GPL-3.0-or-later
"""A body in motion as a faultless pose estimator would see its joints."""

import numpy as np

from w2w.core.body.body import JOINT_INDEX
from w2w.core.motion.skinning import joint_transforms

OTHER_NAMES = {
    "spine": "spine2", "torso": "spine2", "shoulder_center": "shoulders", "thorax": "shoulders",
    "hip_center": "hips", "hip": "hips", "mid_hip": "hips", "nose": "face", "spine_base": "pelvis",
    "spine0": "pelvis", "world": "pelvis", "chest": "spine3", "neck1": "neck", "neck2": "neck",
    "neck_twist0": "neck", "neck_twist1": "neck", "head_end": "head", "head_null": "head", "teeth": "head",
    **{f"tongue{number}": "head" for number in range(5)}, "jaw_null": "head",
    "spine_mid": "spine2", "spine_navel": "spine2", "spine_chest": "spine3", "spine_shoulder": "shoulders",
}  # fmt: skip


def seen_as(joint_set, body, motion):
    """Positions that a faultless pose estimator would give."""
    rotations, positions = joint_transforms(body, motion)
    at = lambda name: positions[:, JOINT_INDEX[name]]  # noqa: E731
    beside = lambda name, *offset: at(name) + rotations[:, JOINT_INDEX[name]] @ np.array(offset)  # noqa: E731

    def position(joint):
        side, _, part = joint.partition("_")
        sign = 1 if side == "left" else -1
        name = OTHER_NAMES.get(joint, joint)
        if name == "neck" and "mid_hip" in joint_set.joints:  # OpenPose's
            name = "shoulders"
        if name in ("shoulders", "hips"):
            return (at(f"left_{name[:-1]}") + at(f"right_{name[:-1]}")) / 2
        if name in ("face", "jaw") or (part == "eye" and "jaw" in joint_set.joints):
            return beside("head", 0, -0.1, 0)
        if part.startswith(("ear", "eye")) or side == "mouth":
            return beside("head", 0.07 * sign, 0, 0)
        if "toe" in part or part in ("foot", "foot_index"):
            return at(f"{side}_foot")
        if "index" in part or "pinky" in part:
            return beside(f"{side}_wrist", 0.1 * sign, -0.03 if "index" in part else 0.03, 0)
        part = part.partition("_twist")[0].removesuffix("_null")
        known = {"pelvis": "pelvis", "heel": f"{side}_ankle", "clavicle": f"{side}_collar"}
        known |= dict.fromkeys(("talocrural", "subtalar", "transversetarsal"), f"{side}_ankle")
        known |= {
            "olecranon": f"{side}_elbow",
            "cubital_fossa": f"{side}_elbow",
            "foot_middle": f"{side}_foot",
        }
        known |= {"acromion": f"{side}_shoulder"}
        if part.startswith(("hand", "middle", "ring", "thumb")):
            return at(f"{side}_hand")
        return at(known.get(part, f"{side}_{part}" if side in ("left", "right") else name))

    return np.stack([position(joint) for joint in joint_set.joints], axis=1)
