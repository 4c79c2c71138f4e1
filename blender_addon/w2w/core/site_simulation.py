# SPDX-License-Identifier: GPL-3.0-or-later
"""Virtual sensors at chosen sites only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from .body import Body
from .imu import Synthesis
from .landmarks import SensorSite
from .motion import Motion
from .patches import PatchSet, sample_patches
from .placements import resolve
from .recording import ImuRecording
from .sensor import SensorModel
from .virtual_imu import record_motion


class SiteSimulator:
    """Records motions at a few sites of a body.

    Parameters
    ----------
    body : Body
    sites : mapping of str to (str or SensorSite)
        Name of each sensor -> a place by name (`placements.resolve`) or a point on a segment.
    settings : Synthesis
    sensor : SensorModel
    seed : int
        Of the sensors' errors.
    """

    def __init__(
        self,
        body: Body,
        sites: Mapping[str, str | SensorSite],
        settings: Synthesis,
        sensor: SensorModel,
        seed: int = 0,
    ) -> None:
        patches = sample_patches(body)
        chosen = [
            resolve(site, body, patches) if isinstance(site, str) else int(patches.labels[site.vertex(body)])
            for site in sites.values()
        ]
        self.body = body
        self.names = tuple(sites)
        self.places = tuple(patches.names[patch] for patch in chosen)
        self._patches = at_places(patches, chosen)
        self._settings, self._sensor, self._seed = settings, sensor, seed

    def record(self, motion: Motion) -> ImuRecording:
        """What the sensors would record, under the sites' names and the motion's labels."""
        recording = record_motion(self.body, self._patches, motion, self._settings, self._sensor, self._seed)
        return replace(recording, sites=self.names)


def at_places(patches: PatchSet, chosen: list[int]) -> PatchSet:
    """The same patches, of which only the chosen carry sensors."""
    return replace(
        patches,
        vertices=patches.vertices[chosen],
        triangles=patches.triangles[chosen],
        regions=tuple(patches.regions[patch] for patch in chosen),
    )
