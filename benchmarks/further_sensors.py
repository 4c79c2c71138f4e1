# SPDX-License-Identifier: GPL-3.0-or-later
"""How much F1 orientation, magnetometer and barometer add to accelerometer and gyroscope, place by place.

    python -m benchmarks.further_sensors LIBRARY --labels labels.csv [--sensor watch]

Every clip is recorded at the 11 placements on the left; the same classifier then learns from acc and gyr
alone, with each of the others, and with all, leaving one subject out at a time. Printed are macro F1 with acc
and gyr, and what each adds, with the 95 % interval over resampled clips, the same for both.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from w2w.core.body.body import Body
from w2w.core.imu.further import FurtherSensors
from w2w.core.imu.recording import FURTHER
from w2w.core.library.library import read_library
from w2w.core.motion.source import UnusableMotion
from w2w.core.patches.body_parts import PLACEMENTS
from w2w.core.ranking.halves import Protocol
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import record
from w2w.core.windows.features import further_features, window_features
from w2w.core.windows.windows import TooShortError, cut_windows
from w2w.headless.options import sensor_settings
from w2w.headless.runs.clip import load_clip
from w2w.studies.comparisons.site_simulator import sensors_at

RESAMPLES = 2000


def main() -> None:
    """Record, rank and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("library", type=Path)
    parser.add_argument("--labels", type=Path, required=True)
    parser.add_argument("--sensor", default="watch")
    asked = parser.parse_args()
    further = FurtherSensors(tuple(FURTHER))
    config = StudyConfig(**sensor_settings(asked.sensor), further=further)
    body = Body.bundled()
    patches = sensors_at(body, {one.name: one.on("left") for one in PLACEMENTS})
    parts, labels = _described(asked.library, asked.labels, body, patches, config)
    maps = {
        "acc and gyr": _ranked([parts["acc and gyr"]], *labels),
        **{name: _ranked([parts["acc and gyr"], parts[name]], *labels) for name in FURTHER},
        "all": _ranked(list(parts.values()), *labels),
    }
    _print(patches.names, maps)


def _described(library, labels, body, patches, config):
    """Features by kind, and activity, clip, subject and test flag of each window."""
    features, rows, is_test, lost = {"acc and gyr": []} | {name: [] for name in FURTHER}, [], [], 0
    for clip in read_library(library, labels).clips:
        try:
            motion = load_clip(clip, body)[1]
            recording = record(body, patches, motion, config)
            windows = cut_windows(recording, config.windows)
        except (UnusableMotion, TooShortError, ValueError):
            lost += 1
            continue
        features["acc and gyr"].append(window_features(windows.signals, recording.rate))
        for name in FURTHER:
            features[name].append(further_features(recording, config.windows, (name,)))
        is_test.append(windows.is_test)
        rows += [(clip.activity, clip.name, clip.subject)] * len(windows.is_test)
    activity, clips, subject = np.array(rows).T
    counts = f"{len(set(activity))} activities, {len(set(subject))} subjects"
    print(f"{len(set(clips))} clips, {lost} left out; {counts}")
    parts = {name: np.concatenate(blocks) for name, blocks in features.items()}
    return parts, (activity, clips, subject, np.concatenate(is_test))


def _ranked(parts, activity, clips, subject, is_test) -> UtilityMap:
    return utility_map(
        np.concatenate(parts, axis=2),
        Protocol(activity, clips, subject, is_test, sorted(set(activity))),
        resamples=RESAMPLES,
        halvings=0,
    )


def _print(places: Sequence[str], maps: dict[str, UtilityMap]) -> None:
    base = maps["acc and gyr"]
    print(f"{base.protocol}, {base.classifier}, {len(base.truth)} windows tested\n")
    print("| placement | acc and gyr | " + " | ".join(name for name in maps if name != "acc and gyr") + " |")
    print("| --- " * (len(maps) + 1) + "|")
    for number, place in enumerate(places):
        cells = [f"{base.mean[number]:.2f}"]
        cells += [_added(base, found, [number]) for name, found in maps.items() if found is not base]
        print(f"| {place} | " + " | ".join(cells) + " |")
    every = list(range(len(places)))
    cells = [f"{base.mean.mean():.2f}"]
    cells += [_added(base, found, every) for found in maps.values() if found is not base]
    print("| mean of all | " + " | ".join(cells) + " |")


def _added(base: UtilityMap, found: UtilityMap, patches: list[int]) -> str:
    added = float((found.mean - base.mean)[patches].mean())
    drawn = (found.mean_samples - base.mean_samples)[:, patches].mean(axis=1)
    low, high = np.quantile(drawn, [0.025, 0.975])
    sure = "**" if low > 0 or high < 0 else ""
    return f"{sure}{added:+.3f}{sure} ({low:+.3f} to {high:+.3f})"


if __name__ == "__main__":
    main()
