# SPDX-License-Identifier: GPL-3.0-or-later
"""Augmented copies of a clip: its variants on other bodies, with sensors worn again, to train on only."""

import hashlib
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..body.body import Body
from ..body.shapes import bundled_targets, shaped
from ..motion.motion import Motion
from ..patches.patches import PatchSet
from .augmentation import Augmentation, remounted
from .further import NOTHING, FurtherSensors
from .recording import ImuRecording
from .sensor import SensorModel
from .synthesis import Synthesis
from .virtual import record_motion

LIMBS = (0.93, 1.07)
"""Length of arms and legs relative to the average, least and most."""

HEIGHTS_M = (1.55, 1.90)
AGES = (25.0, 75.0)
MUSCLE = 0.6


def record_copies(
    body: Body,
    patches: PatchSet,
    motion: Motion,
    plan: Augmentation,
    settings: Synthesis,
    sensor: SensorModel,
    seed: int,
    further: FurtherSensors = NOTHING,
) -> Iterator[ImuRecording]:
    """Record variants of a motion, under its own labels; the same seed and clip give the same ones.

    `body` is the clip's, and the copies' unless the plan has other bodies. Raises ValueError if it has, and
    the body is not W2W's own.
    """
    # a seed for each clip, so that the copies of two clips do not vary alike
    own = int.from_bytes(hashlib.sha256(f"{seed}/{motion.clip}".encode()).digest()[:6], "little")
    for copy, variant in enumerate(plan.motions(motion, own)):
        wearer, moved = body, variant
        if plan.bodies:
            wearer = body_variant(body, copy, seed)
            moved = replace(variant, pelvis=variant.pelvis * (wearer.height / body.height))
        specimen = seed + 1 + copy if plan.noise else seed
        recording = record_motion(wearer, patches, moved, settings, sensor, specimen, further)
        if plan.remount_deg:
            recording = remounted(recording, plan.remount_deg, np.random.default_rng([own, copy, 1]))
        yield recording


def body_variant(body: Body, copy: int, seed: int) -> Body:
    """The body of a copy's number: another sex, height, age, build and length of limbs, drawn from the seed.

    Raises ValueError if the body is not of the bundled one's making: only that can be reshaped.
    """
    if not bundled_targets().fit(body):
        raise ValueError(
            f"augmentation by 'bodies' needs W2W's own body, and {body.name!r} is another: leave it out"
        )
    return _variant(copy, seed)


@lru_cache(maxsize=16)
def _variant(copy: int, seed: int) -> Body:
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
