# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of sensors all over a moving body: skinning, synthesis and sensor model, part by part."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from ..body.body import Body
from ..body.landmarks import SensorSite
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
) -> ImuRecording:
    """Recording of a sensor on every patch, in memory bounded by the recording itself.

    The same as `synthesize` on `patch_matrices` and `SensorModel.apply` on the whole, to rounding; named
    after the patches and labelled as the motion. `seed` is that of the sensors' errors.
    """
    rate = sensor.rate_hz or settings.rate_hz
    n_ideal = count_resampled(motion.n_frames, motion.rate, settings.rate_hz)
    n_samples = count_resampled(n_ideal, settings.rate_hz, rate)
    acc = np.empty((n_samples, len(patches.triangles), 3), dtype=np.float32)
    gyr = np.empty_like(acc)
    others = {name: np.empty((*acc.shape[:2], FURTHER[name]), np.float32) for name in further.record}
    transforms = skinning_transforms(body, motion)
    size = max(1, min(SENSORS_AT_ONCE, BYTES_AT_ONCE // (24 * n_ideal)))
    for start in range(0, len(patches.triangles), size):
        part = slice(start, start + size)
        poses = _SkinnedPatches(body, transforms, patches.triangles[part])
        ideal = synthesize(poses, motion.rate, settings)
        labelled = ImuRecording(acc=ideal.acc, gyr=ideal.gyr, rate=ideal.rate, clip=motion.clip)
        read = sensor.apply(labelled, seed, first_sensor=start)
        acc[:, part], gyr[:, part] = read.acc, read.gyr
        found = further_signals(poses, motion.rate, settings, sensor, further, motion.clip, seed, start)
        for name, values in found.items():
            others[name][:, part] = values
    return ImuRecording(
        acc=acc,
        gyr=gyr,
        rate=rate,
        sites=patches.names,
        activity=motion.activity,
        subject=motion.subject,
        clip=motion.clip,
        **others,
    )


class _SkinnedPatches:
    """World matrices of patches, made for the patches asked for when they are asked for."""

    def __init__(self, body: Body, transforms: np.ndarray, triangles: np.ndarray) -> None:
        self._body = body
        self._transforms = transforms
        self._triangles = triangles
        self.shape = (len(transforms), len(triangles), 4, 4)

    def __getitem__(self, part: tuple[slice, slice]) -> np.ndarray:
        return posed_patches(self._body, self._triangles[part[1]], self._transforms)


def sensors_at(body: Body, sites: Mapping[str, str | SensorSite]) -> PatchSet:
    """A patch of its own at each place, given by its name (`naming.place`) or as a point on a segment.

    Raises ValueError if a name means no place, or two sites are at one vertex.
    """
    return patches_at(
        body,
        {
            name: place(site, body) if isinstance(site, str) else site.vertex(body)
            for name, site in sites.items()
        },
    )


def sensor_at(body: Body, name: str, sample: Callable[[Body], PatchSet]) -> PatchSet:
    """One sensor at a place by its name, or at the patch of a sample that is called so.

    Raises ValueError if neither a place nor a patch is called that.
    """
    try:
        found = sensors_at(body, {name: name})
        return replace(found, own_names=found.regions)
    except ValueError:
        patches = sample(body)
        names = [patch.lower() for patch in patches.names]
        if plain_words(name) not in names:
            raise
        return at_patches(patches, [names.index(plain_words(name))])


def at_patches(patches: PatchSet, chosen: list[int]) -> PatchSet:
    """The same patches, of which only the chosen carry sensors."""
    return replace(
        patches,
        vertices=patches.vertices[chosen],
        triangles=patches.triangles[chosen],
        regions=tuple(patches.regions[patch] for patch in chosen),
    )
