# SPDX-License-Identifier: GPL-3.0-or-later
"""More samples than motion files: variants of a motion, recorded on other bodies, to train on only.

Variants of a motion are synthesised anew, so their signals are those of a body that moves
so. All keep the clip's name: a clip and its variants are one group and never straddle a split.
"""

import hashlib
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Self

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation, Slerp

from w2w.core.body.body import Body
from w2w.core.body.shapes import bundled_targets, shaped
from w2w.core.body.skeleton import JOINT_NAMES, MIRRORED_JOINTS, N_JOINTS
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.virtual import record_motion
from w2w.core.motion.motion import Motion
from w2w.core.patches.patches import PatchSet
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import measured

SWITCHES = ("tempo", "amplitude", "warp", "mirror", "bodies", "remount", "noise")
"""Names of the parts of an `Augmentation`."""

SIDES = frozenset({"left", "right"})
"""Words of an activity's name that say on which side it is done."""

ACROSS = np.diag([-1.0, 1.0, 1.0])
"""Reflection in the plane between left and right of the T-pose, which faces -y."""

LIMBS = (0.93, 1.07)
"""Length of arms and legs relative to the average, least and most."""

HEIGHTS_M = (1.55, 1.90)
AGES = (25.0, 75.0)
MUSCLE = 0.6


@dataclass(frozen=True)
class Augmentation:
    """Variants of a clip to train on; each part has its own switch.

    Raises ValueError if a number is out of its range.
    """

    copies: int = 4  # variants a clip
    mirror: bool = True  # every other variant has left and right exchanged, unless the activity names a side
    tempo: float = 0.15  # speed varies between 1 / (1 + tempo) and 1 + tempo; 0 is off
    amplitude: float = 0.15  # joint angles are scaled by 1 - amplitude to 1 + amplitude; 0 is off
    warp: float = 0.2  # the speed varies within the clip by this share up and down; 0 is off
    # standard deviation of the angle, about a random axis, by which a sensor is turned; 0 is off
    remount_deg: float = 10.0
    bodies: bool = True  # every variant is done by a body of another shape (`body_variant`)
    noise: bool = True  # every variant is recorded by other specimens of the sensor

    def __post_init__(self) -> None:
        if self.copies < 0:
            raise ValueError(f"copies must be 0 or more, not {self.copies}")
        for name, limit in (("tempo", 2.0), ("amplitude", 1.0), ("warp", 0.9), ("remount_deg", 180.0)):
            if not 0 <= getattr(self, name) <= limit:
                raise ValueError(f"{name} must be between 0 and {limit:g}, not {getattr(self, name)}")

    @classmethod
    def only(cls, switches: Collection[str], copies: int = 4) -> Self:
        """Some of `SWITCHES` at their usual strength, the others off; ValueError where a name is unknown."""
        unknown = sorted(set(switches) - set(SWITCHES))
        if unknown:
            raise ValueError(f"'{unknown[0]}' is no augmentation; there are {', '.join(SWITCHES)}")
        off: dict[str, Any] = {"tempo": 0.0, "amplitude": 0.0, "warp": 0.0, "remount_deg": 0.0}
        off |= {"mirror": False, "bodies": False, "noise": False}
        return cls(copies, **{name: off[name] for name in off if name.removesuffix("_deg") not in switches})

    def motions(self, motion: Motion, seed: int) -> Iterator[Motion]:
        """Variants of a motion, under its own labels; the same seed gives the same ones."""
        # the mirror image of an activity that names its side is another activity
        mirror = self.mirror and SIDES.isdisjoint(re.findall("[a-z]+", motion.activity.lower()))
        for copy in range(self.copies):
            rng = np.random.default_rng([seed, copy])
            variant = mirrored(motion) if mirror and copy % 2 == 0 else motion
            if self.amplitude:
                variant = scaled(variant, 1 + self.amplitude * rng.uniform(-1, 1))
            if self.warp:
                variant = time_warped(variant, self.warp, rng)
            if self.tempo:
                variant = at_tempo(variant, (1 + self.tempo) ** rng.uniform(-1, 1))
            yield variant


def mirrored(motion: Motion) -> Motion:
    """The motion seen in a mirror: what the left side did, the right side does."""
    rotations = ACROSS @ motion.rotations[:, list(MIRRORED_JOINTS)] @ ACROSS
    return replace(motion, rotations=rotations, pelvis=motion.pelvis @ ACROSS)


def at_tempo(motion: Motion, factor: float) -> Motion:
    """The same poses at another speed; 2 is twice as fast.

    The poses stay as they are and the frame rate changes, so nothing is interpolated.
    Speeds scale with the factor and accelerations with its square, falls included: far
    from 1 a jump no longer falls as bodies do.
    """
    return replace(motion, rate=motion.rate * factor)


def scaled(motion: Motion, factor: float, joints: Collection[str] = JOINT_NAMES[1:]) -> Motion:
    """Wider or narrower movements: angles of some joints from their mean rotation, multiplied by a factor.

    The pelvis's own rotation is kept, and so are heading and balance; its path about a straight line is
    scaled when both legs are, as smaller steps make a smaller bob. One side's limbs make the motion
    asymmetric.
    """
    rotations = motion.rotations.copy()
    for joint in (JOINT_NAMES.index(name) for name in joints):
        poses = Rotation.from_matrix(rotations[:, joint])
        mean = poses.mean()
        away = Rotation.from_rotvec(factor * (mean.inv() * poses).as_rotvec())
        rotations[:, joint] = (mean * away).as_matrix()
    pelvis = motion.pelvis
    if {"left_hip", "right_hip"} <= set(joints):
        time = np.linspace(-1.0, 1.0, len(pelvis))[:, None]
        slope = (time * pelvis).sum(axis=0) / max((time**2).sum(), 1e-12)
        line = pelvis.mean(axis=0) + time * slope  # least squares
        pelvis = line + factor * (pelvis - line)
    return replace(motion, rotations=rotations, pelvis=pelvis)


def time_warped(motion: Motion, strength: float, rng: np.random.Generator) -> Motion:
    """Hurry and linger: a smooth, monotone change of the clock, first and last frame kept.

    `strength`, below 1, is the greatest change of speed at the knots, about one a second, as a share.
    Rotations are interpolated on the sphere.
    """
    if motion.n_frames < 3:
        return motion
    n_knots = max(3, round(motion.duration) + 1)
    pace = np.concatenate([[0.0], rng.uniform(1 - strength, 1 + strength, n_knots - 1)]).cumsum()
    clock = PchipInterpolator(np.linspace(0, 1, n_knots), pace / pace[-1])
    frames = np.linspace(0, 1, motion.n_frames)
    moments = np.clip(clock(frames), 0.0, 1.0)
    rotations = np.empty_like(motion.rotations)
    for joint in range(N_JOINTS):
        turns = Slerp(frames, Rotation.from_matrix(motion.rotations[:, joint]))
        rotations[:, joint] = turns(moments).as_matrix()
    path = PchipInterpolator(frames, motion.pelvis)
    return replace(motion, rotations=rotations, pelvis=path(moments))


def remounted(recording: ImuRecording, angle_deg: float, rng: np.random.Generator) -> ImuRecording:
    """Turn every sensor in its place, as when it is put on again: the same motion in other frames, exactly.

    The angle has a standard deviation of `angle_deg`, about an axis drawn evenly from the sphere.
    """
    axis = rng.normal(size=(recording.n_sensors, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    angle = np.radians(angle_deg) * rng.normal(size=(recording.n_sensors, 1))
    turns = Rotation.from_rotvec(axis * angle)
    changed = {
        name: np.einsum("tni,nij->tnj", getattr(recording, name), turns.as_matrix())
        for name in ("acc", "gyr", "magnetometer")
        if getattr(recording, name) is not None
    }
    if recording.orientation is not None:
        before = Rotation.from_quat(recording.orientation[..., [1, 2, 3, 0]].reshape(-1, 4))
        after = before * Rotation.from_quat(np.tile(turns.as_quat(), (recording.n_samples, 1)))
        changed["orientation"] = after.as_quat()[:, [3, 0, 1, 2]].reshape(recording.orientation.shape)
    return replace(recording, **changed)


def copies_of(
    body: Body, patches: PatchSet, motion: Motion, config: StudyConfig, plan: Augmentation | None
) -> Iterator[ImuRecording]:
    """Record variants of a motion, under its own labels; the same seed and clip give the same ones.

    `body` is the clip's, and the copies' unless the plan has other bodies. Raises ValueError if it has, and
    the body is not W2W's own.
    """
    if plan is None:
        return
    if plan.bodies and not bundled_targets().fit(body):  # only that can be reshaped
        raise ValueError(
            f"augmentation by 'bodies' needs W2W's own body, and {body.name!r} is another: leave it out"
        )
    seed = config.seed
    # a seed for each clip, so that the copies of two clips do not vary alike
    own = int.from_bytes(hashlib.sha256(f"{seed}/{motion.clip}".encode()).digest()[:6], "little")
    for copy, variant in enumerate(plan.motions(measured(motion, config), own)):
        wearer, moved = body, variant
        if plan.bodies:
            wearer = body_variant(copy, seed)
            moved = replace(variant, pelvis=variant.pelvis * (wearer.height / body.height))
        specimen = seed + 1 + copy if plan.noise else seed
        recording = record_motion(
            wearer, patches, moved, config.synthesis, config.sensor_model(), specimen, config.further
        )
        if plan.remount_deg:
            recording = remounted(recording, plan.remount_deg, np.random.default_rng([own, copy, 1]))
        yield recording


@lru_cache(maxsize=16)
def body_variant(copy: int, seed: int) -> Body:
    """The body of a copy's number: sex, height, age, build and length of limbs, drawn from the seed."""
    rng = np.random.default_rng([seed, copy, 2])
    arms, legs = rng.uniform(*LIMBS, size=2)
    return shaped(
        Body.bundled(),
        gender=rng.uniform(-1, 1),
        height=rng.uniform(*HEIGHTS_M),
        muscle=rng.uniform(0, MUSCLE),
        age=rng.uniform(*AGES),
        arms=arms,
        legs=legs,
    )
