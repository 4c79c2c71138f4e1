# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint sets that pose estimators write, and which landmark of the body each of their joints stands for."""

from __future__ import annotations

from dataclasses import dataclass

SIDES = ("left", "right")


@dataclass(frozen=True)
class JointSet:
    """The joints of a pose estimator.

    Parameters
    ----------
    name : str
    joints : tuple of str
        In the order of the arrays.
    landmarks : dict of str to tuple of str
        Landmark -> joints whose middle it is. Every set has "left hip", "left knee", "left ankle",
        "left shoulder", "left elbow" and "left wrist" and the same on the right. It may have "spine" (about
        halfway up the trunk), "neck", "head", "left toe", "left hand" (knuckles), "left thumb side" and
        "left little finger side" (of the hand) and "face" (the nose).
    """

    name: str
    joints: tuple[str, ...]
    landmarks: dict[str, tuple[str, ...]]

    def members(self, landmark: str) -> tuple[int, ...]:
        """Indices of the joints whose middle a landmark is; none where the set lacks it."""
        return tuple(self.joints.index(joint) for joint in self.landmarks.get(landmark, ()))


def mirrored(landmark: str) -> str:
    """The landmark on the other side of the body; a middle one is its own mirror."""
    side, _, rest = landmark.partition(" ")
    return f"{SIDES[1 - SIDES.index(side)]} {rest}" if side in SIDES else landmark


def _both(**joints: str | tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """Landmarks of both sides: `knee="{}_knee"` is a pattern that takes the side."""
    found = {}
    for side in SIDES:
        for landmark, patterns in joints.items():
            patterns = (patterns,) if isinstance(patterns, str) else patterns
            found[f"{side} {landmark.replace('_', ' ')}"] = tuple(p.format(side) for p in patterns)
    return found


_LIMBS = {part: "{}_" + part for part in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")}

KINECT_20 = JointSet(
    "Kinect, 20 joints",
    (
        "head", "shoulder_center", "spine", "hip_center",
        "left_shoulder", "left_elbow", "left_wrist", "left_hand",
        "right_shoulder", "right_elbow", "right_wrist", "right_hand",
        "left_hip", "left_knee", "left_ankle", "left_foot",
        "right_hip", "right_knee", "right_ankle", "right_foot",
    ),
    {**_both(**_LIMBS, toe="{}_foot"), "neck": ("shoulder_center",), "head": ("head",)},
)  # fmt: skip
"""Microsoft Kinect v1 in the order of UTD-MHAD's files. Its spine lies a hand's breadth above the hips, too
near to say how the trunk bends, and its hands a few centimetres beyond the wrists: neither is used."""

HUMAN36M_17 = JointSet(
    "Human3.6M, 17 joints",
    (
        "hip", "right_hip", "right_knee", "right_ankle", "left_hip", "left_knee", "left_ankle",
        "spine", "thorax", "nose", "head",
        "left_shoulder", "left_elbow", "left_wrist", "right_shoulder", "right_elbow", "right_wrist",
    ),
    {**_both(**_LIMBS), "spine": ("spine",), "neck": ("thorax",), "head": ("head",)},
)  # fmt: skip
"""The order of Martinez et al. 2017 (doi:10.1109/ICCV.2017.288) and what followed it."""

MM_FIT_17 = JointSet(
    "MM-Fit, 17 joints",
    (
        "hip", "left_hip", "left_knee", "left_ankle", "right_hip", "right_knee", "right_ankle",
        "spine", "thorax", "nose", "head",
        "right_shoulder", "right_elbow", "right_wrist", "left_shoulder", "left_elbow", "left_wrist",
    ),
    HUMAN36M_17.landmarks,
)  # fmt: skip
"""Human3.6M's joints with the sides as MM-Fit's tools name them."""

BODY_34 = JointSet(
    "BODY_34, 34 joints",
    (
        "pelvis", "left_hip", "right_hip", "torso", "left_knee", "right_knee", "neck",
        "left_ankle", "right_ankle", "left_big_toe", "right_big_toe", "left_small_toe", "right_small_toe",
        "left_heel", "right_heel", "nose", "left_eye", "right_eye", "left_ear", "right_ear",
        "left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
        "left_pinky_knuckle", "right_pinky_knuckle", "left_middle_tip", "right_middle_tip",
        "left_index_knuckle", "right_index_knuckle", "left_thumb_tip", "right_thumb_tip",
    ),
    {
        **_both(
            **_LIMBS,
            toe=("{}_big_toe", "{}_small_toe"),
            hand=("{}_index_knuckle", "{}_pinky_knuckle"),
            thumb_side="{}_index_knuckle",
            little_finger_side="{}_pinky_knuckle",
        ),
        "spine": ("torso",),
        "neck": ("neck",),
        "head": ("left_ear", "right_ear"),
        "face": ("nose",),
    },
)  # fmt: skip
"""NVIDIA BodyPoseNet 3D's joints, in the order of VIDIMU's files."""

JOINT_SETS: dict[str, JointSet] = {
    "kinect-20": KINECT_20,
    "human36m-17": HUMAN36M_17,
    "mm-fit-17": MM_FIT_17,
    "body-34": BODY_34,
}
