# SPDX-License-Identifier: GPL-3.0-or-later
"""Does advice stay the same when samples are off by one step of the sensor?

    python -m benchmarks.sensor_step SCRATCH [--only NAME ...] [--draws 100] [--patches 128] [--workers 2]

Libraries as in `benchmarks.repeatability`, run in SCRATCH once. Each draw adds -1, 0 or 1 sensor step to
every value, then ranks and chooses as a run does. Printed for each library: how many
draws give the most common place, F1, interval and set, which those are, and how far F1 moves.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.virtual import at_patches
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import utility_map
from w2w.core.selection.advice import advise
from w2w.core.selection.headline import short
from w2w.core.study.clip_files import signals_file
from w2w.core.study.ranking import set_tests
from w2w.core.study.results import StudyResults
from w2w.core.study.signals import describe
from w2w.core.windows.inputs import ArrayBlocks

from .repeatability import CASES, prepared


@dataclass(frozen=True, eq=False)
class Recorded:
    """A library that was run, of its first patches, which lie as far apart as may be."""

    study: StudyResults
    patches: PatchSet
    pooling: Pooling

    @classmethod
    def open(cls, out: Path, n_patches: int) -> Recorded:
        """Read what a run left."""
        study = StudyResults.load(out)
        first = at_patches(study.patches, list(range(len(study.patches)))[:n_patches])
        return cls(study, first, Pooling.on(study.body(), first))

    def features(self, draw: int) -> np.ndarray:
        """Of all windows, with a step of noise; as they are in draw 0."""
        config = self.study.config()
        sensor, described = config.sensor_model(), []
        steps = {"acc": sensor.accelerometer.resolution, "gyr": sensor.gyroscope.resolution}
        for number, clip in enumerate(self.study.clips):
            rng = np.random.default_rng([draw, number])
            made = ImuRecording.load(signals_file(self.study.out, clip.name)).at(
                range(len(self.pooling.kernel))
            )
            if draw:
                values = {name: getattr(made, name) for name in steps}
                off = {name: steps[name] * rng.integers(-1, 2, one.shape) for name, one in values.items()}
                made = replace(made, **{name: (values[name] + off[name]).astype(np.float32) for name in off})
            described.append(describe(made, config)[0])
        return np.concatenate(described)

    def advised(self, draw: int) -> dict[str, object]:
        """What a run would say of a draw."""
        config, labels = self.study.config(), self.study.labels()
        inputs = ArrayBlocks(self.features(draw))
        utility = utility_map(inputs, labels.protocol(config), config.classifier, pooling=self.pooling)
        tests = set_tests(inputs, labels, config, self.pooling, utility=utility)
        advice = advise(utility, self.patches, self.study.body(), tests, config.target)
        said, best = advice.answer, advice.best
        return {
            "place": said.where.partition(" (")[0],
            "F1": short(said.expected),
            "interval": f"{short(said.low)} to {short(said.high)}",
            "highest patch": self.patches.names[best],
            "sensors to wear together": len(advice.worn.order),
            "exact F1": float(utility.expected_mean[best]),
        }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("scratch", type=Path)
    parser.add_argument("--only", nargs="*", choices=CASES, default=["demo12", "hdm05"])
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--patches", type=int, default=128)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    given.scratch.mkdir(parents=True, exist_ok=True)
    for name in given.only:
        prepared(name, given.scratch, given.workers, given.patches)
        library = Recorded.open(given.scratch / f"{name}_out", given.patches)
        said = [library.advised(draw) for draw in range(1, given.draws + 1)]
        exact = [advice.pop("exact F1") for advice in said]
        print(f"{name}: F1 {min(exact):.4f} to {max(exact):.4f}, standard deviation {np.std(exact):.5f}")
        for what in said[0]:
            value, count = Counter(advice[what] for advice in said).most_common(1)[0]
            print(f"  {what}: {value} in {count} of {len(said)} draws", flush=True)


if __name__ == "__main__":
    main()
