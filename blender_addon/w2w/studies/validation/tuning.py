# SPDX-License-Identifier: GPL-3.0-or-later
"""What may be tuned of a comparison, and what is chosen for a data set by all others.

A setting that was chosen on the set it is reported of says nothing of people; so it is chosen on the others.
The settings, and what they are chosen by, were fixed before any of them was computed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from w2w.core.imu.sensor import SensorModel

from .protocol import Analysis, Protocol


@dataclass(frozen=True)
class Setting:
    """One thing changed in what a protocol fixes."""

    name: str
    cutoff_hz: float | None = None  # band of the motion files' trajectories
    tissue: tuple[float, float, float] | None = None
    """Natural frequency in Hz, damping and gain of soft tissue."""
    noise: bool = True  # whether the simulated sensors have errors
    sources_apart: bool = False
    """Whether an activity's simulated F1 is the mean over the sources that show it, each ranked alone."""

    @property
    def signals(self) -> tuple:
        """What its signals depend on: settings alike in it share them."""
        return self.cutoff_hz, self.tissue, self.noise

    def of(self, protocol: Protocol, analysis: Analysis) -> tuple[Protocol, Analysis]:
        """A protocol and one of its analyses, changed so."""
        sensor = protocol.sensor if self.noise else SensorModel.ideal()
        if self.tissue is not None:
            hertz, damping, gain = self.tissue
            sensor = replace(sensor, soft_tissue_hz=hertz, soft_tissue_damping=damping, soft_tissue_gain=gain)
        cutoff = analysis.cutoff_hz if self.cutoff_hz is None else self.cutoff_hz
        return replace(protocol, sensor=sensor), analysis._replace(cutoff_hz=cutoff)


SETTINGS = (
    Setting("as fixed"),
    Setting("band 5 Hz", cutoff_hz=5.0),
    Setting("band 10 Hz", cutoff_hz=10.0),
    Setting("soft tissue of 15 Hz", tissue=(15.0, 0.4, 0.5)),
    Setting("soft tissue of 6 Hz", tissue=(6.0, 0.3, 0.8)),
    Setting("sensors without errors", noise=False),
    Setting("sources apart", sources_apart=True),
)


class Result(NamedTuple):
    """What a setting reached on a data set."""

    mean_rho: float
    rho_of_mean: float
    cells: float
    regret: float


class Chosen(NamedTuple):
    """What the other sets chose for one, and what it reached there."""

    setting: str
    result: Result
    fixed: Result
    hindsight: Result
    """With the setting chosen, with the protocol's own, and with the best of all on this very set."""
    best: str  # that setting


def leave_one_set_out(results: Mapping[str, Mapping[str, Result]]) -> dict[str, Chosen]:
    """Choose each set's setting by all the others, and say what it reaches.

    `results`: by data set and setting, the first of which is the protocol's own.
    Raises ValueError if there are fewer than two sets.
    """
    if len(results) < 2:
        raise ValueError("to choose on the other data sets there must be two at least")
    found = {}
    for name, own in results.items():
        others = [theirs for other, theirs in results.items() if other != name]
        setting = best_setting(others)
        best = best_setting([own])
        found[name] = Chosen(setting, own[setting], next(iter(own.values())), own[best], best)
    return found


def best_setting(sets: Sequence[Mapping[str, Result]]) -> str:
    """The setting of the highest mean rho by activity over sets; of several alike the least regret."""
    names = list(sets[0])

    def merit(name: str) -> tuple[float, float, int]:
        of = [results[name] for results in sets]
        rho, regret = (np.nan_to_num(np.mean([getattr(one, kind) for one in of]), nan=bad)
                       for kind, bad in (("mean_rho", -1.0), ("regret", 1.0)))  # fmt: skip
        return round(float(rho), 6), -round(float(regret), 6), -names.index(name)

    return max(names, key=merit)
