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
        halfway up the trunk), "neck" (above the shoulders), "head", "left toe", "left hand" (knuckles),
        "left thumb side" and "left little finger side" (of the hand) and "face" (the nose).
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
    {**_both(**_LIMBS, toe="{}_foot"), "head": ("head",)},
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
    {**_both(**_LIMBS), "spine": ("spine",), "head": ("head",)},
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

_FACE = {"head": ("left_ear", "right_ear"), "face": ("nose",)}

COCO_17 = JointSet(
    "COCO, 17 joints",
    (
        "nose", "left_eye", "right_eye", "left_ear", "right_ear", "left_shoulder", "right_shoulder",
        "left_elbow", "right_elbow", "left_wrist", "right_wrist", "left_hip", "right_hip",
        "left_knee", "right_knee", "left_ankle", "right_ankle",
    ),
    {**_both(**_LIMBS), **_FACE},
)  # fmt: skip
"""The order of COCO's keypoint annotations (Lin et al. 2014, doi:10.1007/978-3-319-10602-1_48)."""

BLAZEPOSE_33 = JointSet(
    "BlazePose (MediaPipe), 33 joints",
    (
        "nose", "left_eye_inner", "left_eye", "left_eye_outer", "right_eye_inner", "right_eye",
        "right_eye_outer", "left_ear", "right_ear", "mouth_left", "mouth_right",
        "left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
        "left_pinky", "right_pinky", "left_index", "right_index", "left_thumb", "right_thumb",
        "left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle",
        "left_heel", "right_heel", "left_foot_index", "right_foot_index",
    ),
    {
        **_both(
            **_LIMBS,
            toe="{}_foot_index",
            hand=("{}_index", "{}_pinky"),
            thumb_side="{}_index",
            little_finger_side="{}_pinky",
        ),
        **_FACE,
    },
)  # fmt: skip
"""MediaPipe's pose landmarks, in the order of its guide (ai.google.dev, pose landmarker)."""

OPENPOSE_25 = JointSet(
    "OpenPose BODY_25, 25 joints",
    (
        "nose", "neck", "right_shoulder", "right_elbow", "right_wrist",
        "left_shoulder", "left_elbow", "left_wrist", "mid_hip", "right_hip", "right_knee", "right_ankle",
        "left_hip", "left_knee", "left_ankle", "right_eye", "left_eye", "right_ear", "left_ear",
        "left_big_toe", "left_small_toe", "left_heel", "right_big_toe", "right_small_toe", "right_heel",
    ),
    {
        **_both(**_LIMBS, toe=("{}_big_toe", "{}_small_toe")),
        **_FACE,
    },
)  # fmt: skip
"""OpenPose's BODY_25, in the order of its output documentation (doc/02_output.md). Its neck, like the thorax
of Human3.6M and the Kinect's first, is the point between the shoulders, which the shoulders give."""

KINECT_25 = JointSet(
    "Kinect v2, 25 joints",
    (
        "spine_base", "spine_mid", "neck", "head",
        "left_shoulder", "left_elbow", "left_wrist", "left_hand",
        "right_shoulder", "right_elbow", "right_wrist", "right_hand",
        "left_hip", "left_knee", "left_ankle", "left_foot",
        "right_hip", "right_knee", "right_ankle", "right_foot",
        "spine_shoulder", "left_hand_tip", "left_thumb", "right_hand_tip", "right_thumb",
    ),
    {
        **_both(**_LIMBS, toe="{}_foot", hand="{}_hand_tip"),
        "spine": ("spine_mid",),
        "neck": ("neck",),
        "head": ("head",),
    },
)  # fmt: skip
"""Microsoft's JointType enumeration of the Kinect for Windows SDK 2.0. A thumb alone does not say how the
forearm is turned: it moves against the hand."""

AZURE_KINECT_32 = JointSet(
    "Azure Kinect, 32 joints",
    (
        "pelvis", "spine_navel", "spine_chest", "neck",
        "left_clavicle", "left_shoulder", "left_elbow", "left_wrist",
        "left_hand", "left_hand_tip", "left_thumb",
        "right_clavicle", "right_shoulder", "right_elbow", "right_wrist",
        "right_hand", "right_hand_tip", "right_thumb",
        "left_hip", "left_knee", "left_ankle", "left_foot",
        "right_hip", "right_knee", "right_ankle", "right_foot",
        "head", "nose", "left_eye", "left_ear", "right_eye", "right_ear",
    ),
    {
        **_both(**_LIMBS, toe="{}_foot", hand="{}_hand_tip"),
        "spine": ("spine_navel",),
        "neck": ("neck",),
        "head": ("head",),
        "face": ("nose",),
    },
)  # fmt: skip
"""k4abt_joint_id_t of Microsoft's Azure Kinect Body Tracking SDK."""

HUMANML3D_22 = JointSet(
    "HumanML3D (SMPL), 22 joints",
    (
        "pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2",
        "left_ankle", "right_ankle", "spine3", "left_foot", "right_foot", "neck",
        "left_collar", "right_collar", "head", "left_shoulder", "right_shoulder",
        "left_elbow", "right_elbow", "left_wrist", "right_wrist",
    ),
    {
        **_both(**_LIMBS, toe="{}_foot"),
        "spine": ("spine2",),
        "neck": ("neck",),
        "head": ("head",),
    },
)  # fmt: skip
"""The first 22 joints of SMPL, which HumanML3D keeps (Guo et al. 2022, doi:10.1109/CVPR52688.2022.00509)."""

JOINT_CENTRES = JointSet(
    "joint centres",
    (
        "neck", "head",
        *(
            f"{side}_{part}"
            for side in SIDES
            for part in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist", "toe", "hand")
        ),
    ),
    {**_both(**_LIMBS, toe="{}_toe", hand="{}_hand"), "neck": ("neck",), "head": ("head",)},
)  # fmt: skip
"""What gait models write into C3D files; whatever a file lacks was not seen."""

JOINT_SETS: dict[str, JointSet] = {
    "human36m-17": HUMAN36M_17,
    "coco-17": COCO_17,
    "mm-fit-17": MM_FIT_17,
    "kinect-20": KINECT_20,
    "humanml3d-22": HUMANML3D_22,
    "openpose-25": OPENPOSE_25,
    "kinect-25": KINECT_25,
    "azure-kinect-32": AZURE_KINECT_32,
    "blazepose-33": BLAZEPOSE_33,
    "body-34": BODY_34,
    "joint-centres": JOINT_CENTRES,
}

_HIDDEN = (
    (("left thumb side", "left little finger side"), "turns of the forearms about their own axis"),
    (("left hand",), "bends of the wrists"),
    (("left toe",), "the feet"),
    (("head",), "the head"),
    (("face",), "which way the head is turned"),
    (("spine",), "where the trunk bends (its bend is spread between pelvis and chest)"),
)
"""Landmarks that must all be there, and what cannot be seen without them."""


def unseen(joint_set: JointSet) -> tuple[str, ...]:
    """What of a body's motion a joint set cannot show, in words; sensors there see less than real ones."""
    hidden = [what for needed, what in _HIDDEN if not set(needed) <= set(joint_set.landmarks)]
    return (*hidden, "the shoulder blades", "the fingers")
