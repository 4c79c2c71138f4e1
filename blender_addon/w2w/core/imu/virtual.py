# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of sensors all over a moving body: skinning, synthesis and sensor model, part by part."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..body.body import Body
from ..filtering import count_resampled
from ..motion.motion import Motion
from ..motion.skinning import posed_patches, skinning_transforms
from ..patches.naming import place
from ..patches.own_placements import patches_at
from ..patches.patches import PatchSet
from ..wording import plain_words
from .further import NOTHING, FurtherSensors, further_signals
from .recording import FURTHER, ImuRecording
from .sensor import SensorModel
from .synthesis import Synthesis, synthesize

AS_DEFAULT = Synthesis()
IDEAL = SensorModel.ideal()

SENSORS_AT_ONCE = 128
BYTES_AT_ONCE = 48 * 2**20
"""Sensors, at most, and bytes of the ideal signals that are kept until the sensor model has run."""


def record_motion(
    body: Body,
    patches: PatchSet,
    motion: Motion,
    settings: Synthesis = AS_DEFAULT,
    sensor: SensorModel = IDEAL,
    seed: int = 0,
    further: FurtherSensors = NOTHING,
    chosen: Sequence[int] | None = None,
) -> ImuRecording:
    """Recording of a sensor on every patch, or the `chosen`, in memory bounded by the recording itself.

    The same as `synthesize` on `patch_matrices` and `SensorModel.apply` on the whole, to rounding; named
    after the patches and labelled as the motion. `seed` is that of the sensors' errors.
    """
    numbers = range(len(patches.triangles)) if chosen is None else [int(number) for number in chosen]
    rate = sensor.rate_hz or settings.rate_hz
    n_ideal = count_resampled(motion.n_frames, motion.rate, settings.rate_hz)
    n_samples = count_resampled(n_ideal, settings.rate_hz, rate)
    sizes = {"acc": 3, "gyr": 3} | {name: FURTHER[name] for name in further.record}
    signals: dict[str, Any] = {
        name: np.empty((n_samples, len(numbers), size), np.float32) for name, size in sizes.items()
    }
    transforms = skinning_transforms(body, motion)
    size = max(1, min(SENSORS_AT_ONCE, BYTES_AT_ONCE // (24 * n_ideal)))
    for start in range(0, len(numbers), size):
        part = slice(start, start + size)
        poses = _SkinnedPatches(body, transforms, patches.triangles[list(numbers[part])])
        ideal = replace(synthesize(poses, motion.rate, settings), clip=motion.clip)
        read = sensor.apply(ideal, seed, numbers[part])
        signals["acc"][:, part], signals["gyr"][:, part] = read.acc, read.gyr
        others = further_signals(
            poses, motion.rate, settings, sensor, further, motion.clip, seed, numbers[part]
        )
        for name, values in others.items():
            signals[name][:, part] = values
    names = tuple(patches.names[number] for number in numbers)
    return ImuRecording(rate=rate, **signals).labelled(names, motion.activity, motion.subject, motion.clip)


class _SkinnedPatches:
    """World matrices of patches, made for the patches asked for when they are asked for."""

    def __init__(self, body: Body, transforms: np.ndarray, triangles: np.ndarray) -> None:
        self._body = body
        self._transforms = transforms
        self._triangles = triangles
        self.shape = (len(transforms), len(triangles), 4, 4)

    def __getitem__(self, part: tuple[slice, slice]) -> np.ndarray:
        return posed_patches(self._body, self._triangles[part[1]], self._transforms)


def sensor_at(body: Body, name: str, sample: Callable[[Body], PatchSet]) -> PatchSet:
    """One sensor at a place by its name, or at the patch of a sample that is called so.

    Raises ValueError if neither a place nor a patch is called that.
    """
    try:
        own = patches_at(body, {name: place(name, body)})
        return replace(own, own_names=own.regions)
    except ValueError:
        patches, words = sample(body), plain_words(name)
        called = [patch for patch, own in enumerate(patches.names) if own.lower() == words]
        if not called:
            raise
        return at_patches(patches, called[:1])


def at_patches(patches: PatchSet, chosen: list[int]) -> PatchSet:
    """The patches, of which only the chosen carry sensors."""
    return replace(
        patches,
        vertices=patches.vertices[chosen],
        triangles=patches.triangles[chosen],
        regions=tuple(patches.regions[patch] for patch in chosen),
    )
