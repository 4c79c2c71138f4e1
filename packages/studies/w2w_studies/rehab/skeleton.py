# SPDX-License-Identifier: GPL-3.0-or-later
"""The skeleton of the generated exercises: Mixamo's bone names on a human of any size."""

from dataclasses import dataclass

import numpy as np

PREFIX = "mixamorig:"

_TRUNK = (
    ("Hips", None),
    ("Spine", "Hips"),
    ("Spine1", "Spine"),
    ("Spine2", "Spine1"),
    ("Neck", "Spine2"),
    ("Head", "Neck"),
    ("HeadTop_End", "Head"),
)
_ARM = (
    ("Shoulder", "Spine2"),
    ("Arm", "Shoulder"),
    ("ForeArm", "Arm"),
    ("Hand", "ForeArm"),
    ("HandMiddle1", "Hand"),
)
_LEG = (("UpLeg", "Hips"), ("Leg", "UpLeg"), ("Foot", "Leg"), ("ToeBase", "Foot"), ("Toe_End", "ToeBase"))
SIDES = ("Left", "Right")
SIGNS = np.array([1.0, -1.0])
"""Sign of x on the left and the right."""


def _with_sides() -> tuple[tuple[str, str | None], ...]:
    rows = list(_TRUNK)
    for side in SIDES:
        for limb in (_ARM, _LEG):
            middle = {parent for _, parent in limb} & {name for name, _ in _TRUNK}
            rows += [(side + name, parent if parent in middle else side + parent) for name, parent in limb]
    return tuple(rows)


_ROWS = _with_sides()
BONES: tuple[str, ...] = tuple(name for name, _ in _ROWS)
"""The 27 bones without Mixamo's prefix; parents come before their children."""

BONE_INDEX: dict[str, int] = {name: index for index, name in enumerate(BONES)}
BONE_PARENTS: tuple[int, ...] = tuple(-1 if parent is None else BONE_INDEX[parent] for _, parent in _ROWS)

# Heights and lengths as fractions of stature (Drillis and Contini 1966, in Winter 2009, figure 4.1); the
# shoulder stands inside the acromion, the spine's joints are spread evenly over the trunk.
_HIP, _THIGH, _SHANK, _ANKLE = 0.530, 0.245, 0.246, 0.039
_UPPER_ARM, _FOREARM, _PALM = 0.172, 0.150, 0.055
_SHOULDER_HEIGHT = 0.815
_SPINE = {  # height, depth (positive is backward)
    "Hips": (0.560, 0.000),
    "Spine": (0.612, 0.004),
    "Spine1": (0.668, 0.010),
    "Spine2": (0.728, 0.014),
    "Neck": (0.838, 0.012),
    "Head": (0.880, 0.002),
    "HeadTop_End": (1.000, 0.000),
}
_BALL, _BALL_HEIGHT, _TOE_TIP = 0.075, 0.012, 0.117

_SEGMENTS = (  # mass fraction, proximal joint, distal joint, centre of mass from the proximal joint
    (0.081, "Neck", "HeadTop_End", 0.45),
    (0.497, "Hips", "Neck", 0.41),
    *((0.028, f"{side}Arm", f"{side}ForeArm", 0.436) for side in SIDES),
    *((0.022, f"{side}ForeArm", f"{side}Hand", 0.682) for side in SIDES),
    *((0.100, f"{side}UpLeg", f"{side}Leg", 0.433) for side in SIDES),
    *((0.0465, f"{side}Leg", f"{side}Foot", 0.433) for side in SIDES),
    *((0.0145, f"{side}Foot", f"{side}ToeBase", 0.50) for side in SIDES),
)
"""Winter 2009, table 4.1 (after Dempster); the hand counts with the forearm. The trunk's centre is halfway
between hip and shoulder joints there, which is 0.41 of the way from the hips bone to the neck here."""


@dataclass(frozen=True)
class Figure:
    """Size and proportions of a person.

    Raises ValueError if a size is not one a grown-up may have.
    """

    stature: float = 1.70  # metres
    legs: float = 1.0
    arms: float = 1.0
    breadth: float = 1.0
    """Length of the legs, length of the arms and width of hips and shoulders, as multiples of the average for
    that stature."""

    def __post_init__(self) -> None:
        if not 1.2 <= self.stature <= 2.3:
            raise ValueError(f"stature must lie between 1.2 and 2.3 m, not {self.stature}")
        for name in ("legs", "arms", "breadth"):
            if not 0.8 <= getattr(self, name) <= 1.2:
                raise ValueError(f"{name} must lie between 0.8 and 1.2, not {getattr(self, name)}")

    @property
    def thigh(self) -> float:
        """Hip to knee, metres."""
        return _THIGH * self.legs * self.stature

    @property
    def shank(self) -> float:
        """Knee to ankle, metres."""
        return _SHANK * self.legs * self.stature

    @property
    def upper_arm(self) -> float:
        """Shoulder to elbow, metres."""
        return _UPPER_ARM * self.arms * self.stature

    @property
    def forearm(self) -> float:
        """Elbow to wrist, metres."""
        return _FOREARM * self.arms * self.stature

    @property
    def hip_half_width(self) -> float:
        """Half the distance between the hip joints, metres."""
        return 0.052 * self.breadth * self.stature

    @property
    def shoulder_half_width(self) -> float:
        """Half the distance between the shoulder joints, metres."""
        return 0.106 * self.breadth * self.stature

    @property
    def hip_height(self) -> float:
        """Height of the hip joints in the T-pose, metres."""
        return self.thigh + self.shank + self.ankle_height

    @property
    def ankle_height(self) -> float:
        """Height of the ankle above the sole, metres."""
        return _ANKLE * self.stature

    @property
    def ball_height(self) -> float:
        """Height of the ball of the foot (joint of the toes) above the sole, metres."""
        return _BALL_HEIGHT * self.stature

    @property
    def ball_ahead(self) -> float:
        """How far the ball of the foot is ahead of the ankle, metres."""
        return _BALL * self.stature

    def rest(self) -> np.ndarray:
        """Joints in the T-pose, shape (27, 3), metres: z up, facing -y, left towards +x, soles on z = 0."""
        places = self._trunk()
        for side, sign in zip(SIDES, SIGNS, strict=True):
            places |= {side + name: place * [sign, 1, 1] for name, place in self._limbs(places).items()}
        return np.array([places[name] for name in BONES])

    def _trunk(self) -> dict[str, np.ndarray]:
        # longer legs leave a shorter trunk, so the stature stays what it is
        scale = (self.stature - self.hip_height) / (1.0 - _HIP)
        return {
            name: np.array([0.0, depth * self.stature, self.hip_height + scale * (height - _HIP)])
            for name, (height, depth) in _SPINE.items()
        }

    def _limbs(self, trunk: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        size = self.stature
        chest, neck = trunk["Spine2"], trunk["Neck"]
        span = (_SHOULDER_HEIGHT - _SPINE["Spine2"][0]) / (_SPINE["Neck"][0] - _SPINE["Spine2"][0])
        shoulder = chest + span * (neck - chest)
        arm = shoulder + [self.shoulder_half_width, 0.004 * size, 0.0]
        knee_height = self.shank + self.ankle_height
        hip = np.array([self.hip_half_width, 0.0, self.hip_height])
        along = np.array([1.0, 0.0, 0.0])
        elbow = arm + along * self.upper_arm
        wrist = elbow + along * self.forearm
        return {
            "Shoulder": shoulder + [0.020 * size, 0.0, 0.004 * size],
            "Arm": arm,
            "ForeArm": elbow,
            "Hand": wrist,
            "HandMiddle1": wrist + along * _PALM * self.arms * size,
            "UpLeg": hip,
            "Leg": np.array([hip[0], 0.0, knee_height]),
            "Foot": np.array([hip[0], 0.0, self.ankle_height]),
            "ToeBase": np.array([hip[0], -_BALL * size, _BALL_HEIGHT * size]),
            "Toe_End": np.array([hip[0], -_TOE_TIP * size, _BALL_HEIGHT * size]),
        }


def draw_figure(rng: np.random.Generator) -> Figure:
    """A grown-up at random: stature about 1.70 m with a standard deviation of 8 cm, at most 18 cm off."""
    stature, legs, arms, breadth = np.clip(rng.standard_normal(4), -2.2, 2.2)
    return Figure(
        stature=1.70 + 0.08 * stature, legs=1 + 0.02 * legs, arms=1 + 0.025 * arms, breadth=1 + 0.05 * breadth
    )


def centre_of_mass(joints: np.ndarray) -> np.ndarray:
    """Centre of mass of the whole body.

    `joints` (..., 27, 3): world positions, metres.
    Returns (..., 3).
    """
    mass = np.array([row[0] for row in _SEGMENTS])
    near, far = (joints[..., [BONE_INDEX[row[k]] for row in _SEGMENTS], :] for k in (1, 2))
    share = np.array([row[3] for row in _SEGMENTS])[:, None]
    return np.einsum("...sk,s->...k", near + share * (far - near), mass / mass.sum())


def forward_kinematics(
    rest: np.ndarray, rotations: np.ndarray, hips: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """World rotation and position of every bone.

    `rest` (27, 3): joints in the T-pose, metres.
    `rotations` (T, 27, 3, 3): of each bone relative to its parent, in the axes of the T-pose.
    `hips` (T, 3): world position of the hips, metres.
    Returns `rotations` (T, 27, 3, 3): in the world, relative to the T-pose; `joints` (T, 27, 3): positions
    in the world, metres.
    """
    world = rotations.copy()
    joints = np.empty((len(hips), len(BONES), 3))
    joints[:, 0] = hips
    for bone, parent in enumerate(BONE_PARENTS[1:], start=1):
        world[:, bone] = world[:, parent] @ rotations[:, bone]
        joints[:, bone] = joints[:, parent] + world[:, parent] @ (rest[bone] - rest[parent])
    return world, joints
