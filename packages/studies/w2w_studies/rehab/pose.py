# SPDX-License-Identifier: GPL-3.0-or-later
"""From what an exercise asks of pelvis, trunk, feet and hands to the rotations of all bones."""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from .curves import soft_excess, soft_limit
from .skeleton import (
    BONE_INDEX,
    BONE_PARENTS,
    BONES,
    SIDES,
    SIGNS,
    Figure,
    centre_of_mass,
    forward_kinematics,
)
from .two_bones import reach, two_bones

STRAIGHTEST_ELBOW = np.radians(10.0)
_LIMIT_BAND = 0.006
_BALANCE_ROUNDS = 5

# A shoulder blade turns one degree for every two of the upper arm once the arm is well raised
# (Inman et al. 1944, doi:10.2106/00004623-194426010-00001); about half of that is the collar bone's.
_CLAVICLE_SHARE, _CLAVICLE_FROM, _CLAVICLE_BAND = 0.22, np.radians(35.0), np.radians(20.0)


@dataclass
class PosePlan:
    """What an exercise asks of the body in each of T frames.

    World axes: z up, the person facing -y, left towards +x; metres and radians. Turns are
    (pitch forward, list to the left, yaw to the left). Arrays of a pair hold left, right.
    """

    pelvis: np.ndarray  # (T, 3): middle between the hip joints; lower where the legs cannot reach so high
    pelvis_turn: np.ndarray
    chest_turn: np.ndarray
    head_turn: np.ndarray
    """(T, 3): in world axes."""
    balls: np.ndarray  # (2, T, 3): ball of each foot (joint of the toes)
    heel_rise: np.ndarray
    toe_dip: np.ndarray
    """(2, T): pitch of foot and toes, positive with the toes down."""
    foot_yaw: np.ndarray  # (2,): how far each foot, and the knee over it, points to the left
    knee_bend: np.ndarray
    """(2, T): no knee is straighter than this: a pelvis planned too high comes to stand on such knees."""
    lifted: np.ndarray
    """(2, T): 0 leaves the foot where `balls` says, 1 hangs the leg from the pelvis by the angles below."""
    hip_flexion: np.ndarray
    knee_flexion: np.ndarray
    """(2, T): angles of a lifted leg."""
    hands: np.ndarray
    """(2, T, 3): wrist relative to the shoulder joint, in axes that follow the chest by `arms_follow`."""
    hand_sway: np.ndarray
    """(2, T, 3): added to `hands`, as far as it swings the arm and does not stretch it; metres."""
    elbow_sway: np.ndarray  # (2, T): added to the bend of the elbows
    elbows: np.ndarray  # (2, T, 3): where each elbow points to, in the same axes
    arms_follow: np.ndarray
    """(T,): 0: those axes stay level with the world (arms hang down), 1: they lean with the chest."""
    on_thighs: np.ndarray
    """(2, T): 0 leaves the hand where `hands` says, 1 lays it on the thigh above the knee."""
    pronation: np.ndarray
    """(2, T): turn of the forearm, positive with the palms turning backward when hanging."""
    grounded: np.ndarray  # (T, 2): where on the floor the centre of mass should be
    balance: np.ndarray
    """(T,): 1 moves the pelvis until the centre of mass is over `grounded`, 0 leaves the pelvis alone."""


def turn(angles: np.ndarray) -> np.ndarray:
    """Rotation matrices of (pitch forward, list to the left, yaw to the left), shape (..., 3, 3)."""
    angles = np.asarray(angles, dtype=float)
    flat = Rotation.from_euler("ZXY", angles.reshape(-1, 3)[:, [2, 0, 1]])
    return flat.as_matrix().reshape(*angles.shape[:-1], 3, 3)


def pose(figure: Figure, plan: PosePlan) -> tuple[np.ndarray, np.ndarray]:
    """Rotations of all bones that do what the plan asks.

    Feet are exact where they stand: the legs are solved as two bones with the knee over
    the foot. Arms are solved the same way.

    Returns `rotations` (T, 27, 3, 3): of each bone relative to its parent, in the axes of the T-pose; `hips`
    (T, 3): world position of the hips, metres.
    """
    solver = _Solver(figure, plan)
    balanced = plan.pelvis
    if plan.balance.any():
        for _ in range(_BALANCE_ROUNDS):
            error = plan.grounded - centre_of_mass(solver.joints(balanced))[:, :2]
            balanced = balanced + np.pad(error, ((0, 0), (0, 1)))
    pelvis = plan.pelvis + plan.balance[:, None] * (balanced - plan.pelvis)
    world, hips = solver.solve(pelvis)
    return _relative(world), hips


@dataclass
class _Solver:
    """Places one plan's bones for any path of the pelvis."""

    figure: Figure
    plan: PosePlan
    rest: np.ndarray = field(init=False)
    trunk: dict[str, np.ndarray] = field(init=False)

    def __post_init__(self) -> None:
        self.rest = self.figure.rest()
        self.trunk = _trunk(self.plan)

    def joints(self, pelvis: np.ndarray) -> np.ndarray:
        """World positions of all bones, shape (T, 27, 3)."""
        world, hips = self.solve(pelvis)
        return forward_kinematics(self.rest, _relative(world), hips)[1]

    def solve(self, pelvis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """World rotations (T, 27, 3, 3) and hips (T, 3)."""
        world = np.broadcast_to(np.eye(3), (len(pelvis), len(BONES), 3, 3)).copy()
        for name, matrices in self.trunk.items():
            world[:, BONE_INDEX[name]] = matrices
        feet = [self._foot(side, pelvis) for side in (0, 1)]
        pelvis = self._within_reach(pelvis, [ankle for ankle, _, _ in feet])
        hip_joints = [self._hip(side, pelvis) for side in (0, 1)]
        for side in (0, 1):
            self._place_leg(world, side, hip_joints[side], feet[side])
        hips = pelvis + self.trunk["Hips"] @ (self._at("Hips") - self._middle())
        chest = self._chest(hips)
        for side in (0, 1):
            self._place_arm(world, side, chest, hip_joints[side])
        return world, hips

    def _at(self, name: str) -> np.ndarray:
        return self.rest[BONE_INDEX[name]]

    def _middle(self) -> np.ndarray:
        return (self._at("LeftUpLeg") + self._at("RightUpLeg")) / 2

    def _hip(self, side: int, pelvis: np.ndarray) -> np.ndarray:
        return pelvis + self.trunk["Hips"] @ (self._at(SIDES[side] + "UpLeg") - self._middle())

    def _foot(self, side: int, pelvis: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ankle (T, 3), foot and toe rotations: on the ground, in the air or between the two."""
        plan, name = self.plan, SIDES[side]
        yaw = np.full(len(pelvis), plan.foot_yaw[side])
        level = np.zeros_like(yaw)
        foot = turn(np.stack([plan.heel_rise[side], level, yaw], axis=-1))
        toes = turn(np.stack([plan.toe_dip[side], level, yaw], axis=-1))
        to_ball = self._at(name + "ToeBase") - self._at(name + "Foot")
        hanging = self._hanging_ankle(side, pelvis) + foot @ to_ball
        ball = plan.balls[side] + plan.lifted[side][:, None] * (hanging - plan.balls[side])
        return ball - foot @ to_ball, foot, toes

    def _hanging_ankle(self, side: int, pelvis: np.ndarray) -> np.ndarray:
        """Where the ankle is when the leg hangs from the pelvis by hip and knee angle."""
        plan, figure = self.plan, self.figure
        hip, knee = plan.hip_flexion[side], plan.knee_flexion[side]
        yawed = turn(np.stack([0 * hip, plan.pelvis_turn[:, 1], 0 * hip + plan.foot_yaw[side] / 2], axis=-1))
        bones = figure.thigh * _down(hip) + figure.shank * _down(hip - knee)
        return self._hip(side, pelvis) + np.einsum("tij,tj->ti", yawed, bones)

    def _within_reach(self, pelvis: np.ndarray, ankles: list[np.ndarray]) -> np.ndarray:
        """Lower the pelvis where a leg would have to be straighter than the plan allows."""
        height = pelvis[:, 2]
        for side, ankle in enumerate(ankles):
            hip = self._hip(side, pelvis)
            longest = reach(self.figure.thigh, self.figure.shank, self.plan.knee_bend[side])
            across = np.sum((hip - ankle)[:, :2] ** 2, axis=1)
            highest = ankle[:, 2] + np.sqrt(longest**2 - across) - (hip[:, 2] - pelvis[:, 2])
            height = soft_limit(height, highest, _LIMIT_BAND)
        return np.column_stack([pelvis[:, :2], height])

    def _place_leg(
        self, world: np.ndarray, side: int, hip: np.ndarray, foot: tuple[np.ndarray, np.ndarray, np.ndarray]
    ) -> None:
        name, yaw = SIDES[side], self.plan.foot_yaw[side]
        ankle, foot_turn, toe_turn = foot
        # the knee looks where the foot does, and turns half as far as the pelvis does
        ahead = turn(np.stack([0 * hip[:, 0], 0 * hip[:, 0], yaw + self.plan.pelvis_turn[:, 2] / 2], axis=-1))
        knees = ahead @ np.array([0.0, -1.0, 0.0])
        thigh, shank = two_bones(
            ankle - hip, knees, self.figure.thigh, self.figure.shank, (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)
        )
        for bone, matrices in (("UpLeg", thigh), ("Leg", shank), ("Foot", foot_turn), ("ToeBase", toe_turn)):
            world[:, BONE_INDEX[name + bone]] = matrices
        world[:, BONE_INDEX[name + "Toe_End"]] = toe_turn

    def _chest(self, hips: np.ndarray) -> np.ndarray:
        """World position (T, 3) of the bone that carries the shoulders."""
        position = hips
        for parent, child in (("Hips", "Spine"), ("Spine", "Spine1"), ("Spine1", "Spine2")):
            position = position + self.trunk[parent] @ (self._at(child) - self._at(parent))
        return position

    def _place_arm(self, world: np.ndarray, side: int, chest: np.ndarray, hip: np.ndarray) -> None:
        plan, name, sign = self.plan, SIDES[side], SIGNS[side]
        upper, fore = self.figure.upper_arm, self.figure.forearm
        leaning = np.column_stack([plan.arms_follow, plan.arms_follow, np.ones(len(chest))])
        axes = turn(plan.chest_turn * leaning)
        hand = np.einsum("tij,tj->ti", axes, _swayed(plan.hands[side], plan.hand_sway[side]))
        elbow = np.einsum("tij,tj->ti", axes, plan.elbows[side])

        clavicle = self.trunk["Spine2"] @ _clavicle(plan.hands[side], sign)
        shoulder = chest + self.trunk["Spine2"] @ (self._at(name + "Shoulder") - self._at("Spine2"))
        shoulder = shoulder + clavicle @ (self._at(name + "Arm") - self._at(name + "Shoulder"))

        thigh = world[:, BONE_INDEX[name + "UpLeg"]]
        on_thigh = np.array([0.025 * sign, -0.07, -0.55 * self.figure.thigh])
        resting = self._reachable(hip + thigh @ on_thigh - shoulder, 0.0)
        target = hand + plan.on_thighs[side][:, None] * (resting - hand)
        target = self._reachable(target, plan.elbow_sway[side])
        bent, straight = two_bones(target, elbow, upper, fore, (sign, 0.0, 0.0), (0.0, 0.0, -sign))
        twist = np.array([1.0, 0.0, 0.0]) * plan.pronation[side][:, None]
        forearm = straight @ Rotation.from_rotvec(0.5 * twist).as_matrix()
        palm = straight @ Rotation.from_rotvec(twist).as_matrix()
        for bone, matrices in (("Shoulder", clavicle), ("Arm", bent), ("ForeArm", forearm), ("Hand", palm)):
            world[:, BONE_INDEX[name + bone]] = matrices
        world[:, BONE_INDEX[name + "HandMiddle1"]] = palm

    def _reachable(self, target: np.ndarray, more_bend: np.ndarray | float) -> np.ndarray:
        """The target (T, 3) brought as close to the shoulder as an arm reaches that is bent a little more."""
        upper, fore = self.figure.upper_arm, self.figure.forearm
        distance = np.linalg.norm(target, axis=1)
        held = soft_limit(distance, reach(upper, fore, STRAIGHTEST_ELBOW), 2 * _LIMIT_BAND)
        bend = np.arccos((held**2 - upper**2 - fore**2) / (2 * upper * fore))
        return target * (reach(upper, fore, bend + more_bend) / distance)[:, None]


def _down(flexion: np.ndarray) -> np.ndarray:
    """Unit vectors (T, 3): down for 0, forward for 90 degrees."""
    return np.stack([0 * flexion, -np.sin(flexion), -np.cos(flexion)], axis=-1)


def _trunk(plan: PosePlan) -> dict[str, np.ndarray]:
    """World rotations from hips to head: the spine and the neck share their bends evenly."""
    pelvis, chest, head = (turn(angles) for angles in (plan.pelvis_turn, plan.chest_turn, plan.head_turn))
    spine, neck = _bend(pelvis, chest), _bend(chest, head)
    return {
        "Hips": pelvis,
        "Spine": pelvis @ _part(spine, 1 / 3),
        "Spine1": pelvis @ _part(spine, 2 / 3),
        "Spine2": chest,
        "Neck": chest @ _part(neck, 1 / 2),
        "Head": head,
        "HeadTop_End": head,
    }


def _swayed(hand: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Wrist moved by the part of the offset that is at right angles to the line from the shoulder."""
    along = np.sum(hand * offset, axis=1, keepdims=True) / np.sum(hand**2, axis=1, keepdims=True)
    return hand + offset - along * hand


def _bend(parent: np.ndarray, child: np.ndarray) -> np.ndarray:
    return Rotation.from_matrix(parent.transpose(0, 2, 1) @ child).as_rotvec()


def _part(bend: np.ndarray, share: float) -> np.ndarray:
    return Rotation.from_rotvec(share * bend).as_matrix()


def _clavicle(hand: np.ndarray, sign: float) -> np.ndarray:
    """Turn of the collar bone relative to the chest, shape (T, 3, 3): it rises with the raised arm."""
    raised = np.arctan2(np.linalg.norm(hand[:, :2], axis=1), -hand[:, 2])
    rise = _CLAVICLE_SHARE * soft_excess(raised - _CLAVICLE_FROM, _CLAVICLE_BAND)
    return turn(np.stack([0 * rise, -sign * rise, 0 * rise], axis=-1))


def _relative(world: np.ndarray) -> np.ndarray:
    """Rotation of each bone relative to its parent."""
    local = world.copy()
    parents = np.array(BONE_PARENTS[1:])
    local[:, 1:] = world[:, parents].transpose(0, 1, 3, 2) @ world[:, 1:]
    return local
