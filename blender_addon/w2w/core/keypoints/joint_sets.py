# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint sets that pose estimators write, and the landmarks of the body that their joints are."""

from dataclasses import dataclass

from ..body.body import template

SIDES = ("left", "right")

LIMBS = ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
"""Landmarks that every set has on both sides."""


@dataclass(frozen=True)
class JointSet:
    """The joints of a pose estimator, and which joints' middle each landmark is.

    Every set has "left hip", "left knee", "left ankle", "left shoulder", "left elbow" and "left wrist" and
    the same on the right. It may have "spine" (about halfway up the trunk), "neck" (above the shoulders),
    "head", "left toe", "left hand" (knuckles), "left thumb side" and "left little finger side" (of the hand)
    and "face" (the nose).
    """

    name: str
    joints: tuple[str, ...]  # in the order of the arrays
    landmarks: dict[str, tuple[str, ...]]  # landmark -> joints

    def __post_init__(self) -> None:
        lacking = {f"{side} {limb}" for side in SIDES for limb in LIMBS} - set(self.landmarks)
        lacking |= {joint for joints in self.landmarks.values() for joint in joints} - set(self.joints)
        if lacking or len(set(self.joints)) < len(self.joints):
            raise ValueError(f"joint set {self.name}: it lacks {sorted(lacking)} or names a joint twice")

    def members(self, landmark: str) -> tuple[int, ...]:
        """Indices of the joints whose middle is a landmark; () if the set lacks it."""
        return tuple(self.joints.index(joint) for joint in self.landmarks.get(landmark, ()))


def mirrored(landmark: str) -> str:
    """The landmark on the other side of the body; a middle one is its own mirror."""
    side, _, rest = landmark.partition(" ")
    return f"{SIDES[1 - SIDES.index(side)]} {rest}" if side in SIDES else landmark


JOINT_SETS = {
    key: JointSet(
        given["name"],
        tuple(given["joints"]),
        {landmark: tuple(joints) for landmark, joints in given["landmarks"].items()},
    )
    for key, given in template("joint_sets.json").items()
}
"""Joint sets by the names that `--pose-joints` takes."""

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
    """Parts of a body's motion that a joint set cannot show, in words: real sensors there read more."""
    hidden = [what for needed, what in _HIDDEN if not set(needed) <= set(joint_set.landmarks)]
    return (*hidden, "the shoulder blades", "the fingers")
