# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulated sensors at the sites where people wore real ones."""

from collections.abc import Mapping
from dataclasses import replace

from w2w.core.body.body import Body
from w2w.core.body.landmarks import SensorSite
from w2w.core.imu.presets import DEFAULT_SENSOR, PRESETS, wearing_sentences
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import Synthesis
from w2w.core.imu.virtual import record_motion
from w2w.core.motion.motion import Motion
from w2w.core.patches.naming import place
from w2w.core.patches.own_placements import patches_at
from w2w.core.patches.patches import PatchSet


class SiteSimulator:
    """Records motions at a few sites of W2W's own body: places by name, or points on a segment."""

    def __init__(
        self,
        sites: Mapping[str, str | SensorSite],
        rate_hz: float,
        sensor: SensorModel = PRESETS[DEFAULT_SENSOR],
        seed: int = 0,
    ) -> None:
        self.body = Body.bundled()
        self._patches = sensors_at(self.body, sites)
        self.names = tuple(sites)
        self.simulated_at = self._patches.regions
        self._settings, self._sensor, self._seed = Synthesis(rate_hz=rate_hz), sensor, seed

    def record(self, motion: Motion) -> ImuRecording:
        """What the sensors would record, under the sites' names and the motion's labels."""
        recording = record_motion(self.body, self._patches, motion, self._settings, self._sensor, self._seed)
        return replace(recording, sites=self.names)


def sensors_at(body: Body, sites: Mapping[str, str | SensorSite]) -> PatchSet:
    """A patch of its own at each place, given by its name (`naming.place`) or as a point on a segment.

    Raises ValueError if a name means no place, or two sites are at one vertex.
    """
    at = {name: place(to, body) if isinstance(to, str) else to.vertex(body) for name, to in sites.items()}
    return patches_at(body, at)


def error_sentence(model: SensorModel) -> str:
    """Whether simulated sensors have a part's errors, for a report.

    Examples
    --------
    >>> error_sentence(SensorModel.ideal())
    'Simulated sensors are free of noise and of every other error.'
    """
    if model.is_ideal:
        return "Simulated sensors are free of noise and of every other error."
    return f"Simulated sensors have the errors of the {model.name}. {wearing_sentences(model)}"
