# SPDX-License-Identifier: GPL-3.0-or-later
"""Bring a rigged body to W2W's convention: metres, z up, facing -y, soles on the ground, in a T-pose."""

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import JOINT_INDEX, N_JOINTS, PARENTS, Body
from ..rotations import frame_of, smallest_rotation

UNITS = (1.0, 0.01, 0.001)
"""Metres, centimetres and millimetres."""

SHORTEST, TALLEST = 0.4, 2.5
"""Heights of people, metres."""

AXIS_ALIGNED = np.radians(25)
"""A body turned by less than this from the file's axes stands along them: people lean and look aside."""

BENT = np.radians(20)
"""An elbow or knee bent by more than this is straightened."""

AWAY = np.radians(12)
"""A limb that points this far from the T-pose's is moved there; less is how people are built."""

LIMBS = tuple(
    tuple(JOINT_INDEX[f"{side}_{part}"] for part in parts)
    for side in ("left", "right")
    for parts in (("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle"))
)


def metres_per_unit(height: float) -> float:
    """Size of a file's unit of length, from the height of the body in it.

    Raises ValueError if no usual unit makes it the height of a person.
    """
    for unit in UNITS:
        if SHORTEST <= height * unit <= TALLEST:
            return unit
    raise ValueError(
        f"the body is {height:g} units tall: expected {SHORTEST:g} to {TALLEST:g} metres, "
        "or as much in centimetres or millimetres"
    )


def to_axes(left: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Rotation (3, 3) from a file's axes to W2W's, from the directions of a body's left and of its head.

    `left` and `up` (3,) have any length and need not be square to each other. It is a permutation of the axes
    if the body nearly stands along them.
    """
    turn = frame_of(left, up).T
    snapped = np.zeros((3, 3))
    longest = np.abs(turn).argmax(axis=1)
    snapped[np.arange(3), longest] = np.sign(turn[np.arange(3), longest])
    aligned = Rotation.from_matrix(turn @ snapped.T) if np.linalg.det(snapped) > 0.5 else None
    return snapped if aligned is not None and aligned.magnitude() < AXIS_ALIGNED else turn


def in_t_pose(
    vertices: np.ndarray,
    joints: np.ndarray,
    weights: np.ndarray,
    reference: Body,
    limbs: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Straighten and raise limbs until a body stands as in W2W's rest pose.

    Limbs that already point as the T-pose's do, apart from a body's own build, stay as they are; others turn
    first in the frontal plane, as an A-pose was made from a T-pose. Posing the result back with linear blend
    skinning gives the vertices that were passed.

    Vertices (V, 3) are in W2W's axes, metres; `reference` stands in the T-pose. `limbs` (24, 3) are joints
    that show where the limbs point now, if those they turn about are placed differently from the
    reference's. Returns the vertices and joints.
    """
    turns = _turns_to_t_pose(joints if limbs is None else limbs, reference.joints)
    if (turns == np.eye(3)).all():
        return vertices, joints
    straight = joints.copy()
    for joint in range(1, N_JOINTS):
        parent = PARENTS[joint]
        straight[joint] = straight[parent] + turns[parent] @ (joints[joint] - joints[parent])
    # the posed vertex is sum w (turn^T (x - straight) + joint): solve for the rest position x
    back = turns.swapaxes(1, 2)
    linear = np.einsum("vj,jab->vab", weights, back)
    constant = weights @ (joints - np.einsum("jab,jb->ja", back, straight))
    return np.linalg.solve(linear, (vertices - constant)[..., None])[..., 0], straight


def on_the_ground(vertices: np.ndarray, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same body with its soles on z = 0 and its pelvis above the origin."""
    foot = np.array([*joints[0, :2], vertices[:, 2].min()])
    return vertices - foot, joints - foot


def _turns_to_t_pose(joints: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """World rotation of each body part, shape (24, 3, 3)."""
    own = {0: np.eye(3)}
    for start, middle, end in LIMBS:
        upper, lower = joints[middle] - joints[start], joints[end] - joints[middle]
        unbend = smallest_rotation(lower, upper) if _angle(lower, upper) > BENT else np.eye(3)
        reach, wanted = upper + unbend @ lower, reference[end] - reference[start]
        raised = _raised(reach, wanted)
        own |= {start: raised, middle: raised @ unbend}
    turns = np.empty((N_JOINTS, 3, 3))
    for joint, parent in enumerate(PARENTS):  # the others go with their parents
        turns[joint] = own.get(joint, turns[parent])
    return turns


def _raised(reach: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Rotation of a whole limb to its direction in the T-pose."""
    if _angle(reach, wanted) <= AWAY:
        return np.eye(3)
    frontal = np.array([1.0, 0.0, 1.0])
    turn = smallest_rotation(frontal * reach, frontal * wanted)
    if _angle(turn @ reach, wanted) > AWAY:
        turn = smallest_rotation(reach, wanted)
    return turn


def _angle(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


BLEND = (-0.1, 0.35)
"""Where the arm's share begins and reaches 1, in lengths of the upper arm outward from the shoulder joint."""

AROUND = (0.4, 0.7)
"""Distances from the arm's axis, in the same unit, between which the rule ceases to hold."""

WITHIN = 0.8
"""The rule holds for so far inward and outward of the joint, in the same unit."""

SLICE = (0.2, 0.4)
"""Part of the upper arm whose middle is taken for the arm's."""

TOWARDS_MIDDLE = 0.5
"""How far the joint is moved, of its way to the middle of the arm."""


def with_smpl_shoulders(
    vertices: np.ndarray, joints: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Give a rig SMPL's shoulders: other shoulder joints, and other weights near them; rows still sum to 1.

    Vertices (V, 3) stand in W2W's T-pose. Returns the joints (24, 3) and weights (V, 24).
    """
    joints, weights = joints.copy(), weights.copy()
    for side, outward in (("left", 1.0), ("right", -1.0)):
        arm = [JOINT_INDEX[f"{side}_{part}"] for part in ("shoulder", "elbow", "wrist", "hand")]
        start, bone = joints[arm[0]].copy(), joints[arm[1]] - joints[arm[0]]
        place = (vertices - start) / np.linalg.norm(bone)
        along = bone / np.linalg.norm(bone)
        share = weights[:, arm].sum(axis=1)
        joints[arm[0]] += TOWARDS_MIDDLE * np.linalg.norm(bone) * _middle(place, along, share)
        depth, aside = outward * place[:, 0], np.linalg.norm(place[:, 1:], axis=1)
        held = (1 - _smoothstep(aside, *AROUND)) * (np.abs(depth) < WITHIN)
        share = np.clip(share + held * (_smoothstep(depth, *BLEND) - share), 0, 1)
        _share_out(weights, arm, JOINT_INDEX[f"{side}_collar"], share)
    return joints, weights


def _middle(place: np.ndarray, along: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Offset from the joint to the middle line of the upper arm, in the frontal plane; 0 without an arm."""
    depth = place @ along
    of_arm = (depth > SLICE[0]) & (depth < SLICE[1]) & (share > 0.5)
    if not of_arm.any():
        return np.zeros(3)
    offset = (place[of_arm].min(axis=0) + place[of_arm].max(axis=0)) / 2
    aside = offset - along * (offset @ along)
    return aside * [1, 0, 1]  # front to back the joints agree already


def _share_out(weights: np.ndarray, arm: list[int], collar: int, share: np.ndarray) -> None:
    """Scale each row's weights on the arm to a share and the others to the rest, in place.

    If a vertex follows none of these joints yet, shoulder and collar take the share.
    """
    trunk = np.setdiff1d(np.arange(weights.shape[1]), arm)
    for joints, taker, due in ((arm, arm[0], share), (trunk, collar, 1 - share)):
        held = weights[:, joints].sum(axis=1)
        bare = held < 1e-6
        weights[:, joints] *= np.where(bare, 0, due / np.where(bare, 1, held))[:, None]
        weights[bare, taker] = due[bare]


def _smoothstep(values: np.ndarray, start: float, end: float) -> np.ndarray:
    share = np.clip((values - start) / (end - start), 0, 1)
    return share * share * (3 - 2 * share)
