# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulated sensors at the sites where people wore real ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from w2w.core.body.body import Body
from w2w.core.body.landmarks import SensorSite
from w2w.core.imu.presets import DEFAULT_SENSOR, PRESETS
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import Synthesis
from w2w.core.imu.virtual import record_motion, sensors_at
from w2w.core.motion.motion import Motion


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
