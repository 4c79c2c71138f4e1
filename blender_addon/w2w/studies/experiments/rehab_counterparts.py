# SPDX-License-Identifier: GPL-3.0-or-later
r"""Do generated rehabilitation exercises rank patches as real ones do, and does each teach the other?

    python -m w2w.studies.experiments.rehab_counterparts rehab_study/library HDM05 [--patches 128] \
        [--bodies "neutral"]

Both folders hold a labels.csv (file, activity, subject). Of the generated ones sit to stand, arm raise and
one-leg stand are taken, of HDM05 what comes nearest: squats, rotating arms, elbow to knee. Each three are
told apart at every patch of every body, leaving one person out; printed are Spearman's rho over patches of
the expected F1 of both sides, what each side could reach at most against another of its kind, and the F1
of a classifier that learnt from one side alone and is tested on the other (mean over patches, and range).
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import spearmanr

from w2w.core.body.body import Body
from w2w.core.imu.presets import preset
from w2w.core.imu.virtual import record_motion
from w2w.core.library.library import read_library
from w2w.core.motion.motion import Motion
from w2w.core.motion.source import UnusableMotion
from w2w.core.patches.patches import PatchSet, sample_patches
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.f1 import ClipUnits, f1_scores
from w2w.core.ranking.folds import ALWAYS_TRAIN
from w2w.core.ranking.halves import Protocol
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.windows.features import window_features
from w2w.core.windows.windows import WindowSpec, cut_windows
from w2w.headless.options import parse_bodies
from w2w.headless.runs.clip import load_clip

PAIRS = {
    "sit_to_stand": ("standing up or squatting", "squat"),
    "arm_raise_band": ("raising the arms", "rotate_arms"),
    "one_leg_stand": ("on one leg", "elbow_to_knee"),
}
"""Generated exercise -> what both are called here, and HDM05's."""

BODIES = "neutral, female height=1.55 weight=50, male height=1.90 weight=100"


LAST_COLUMNS = (
    "generated, HDM05 at most",
    "generated to HDM05",
    "HDM05 to generated",
    "best patch of the generated, F1 there on HDM05, best on HDM05",
)


class Side(NamedTuple):
    """Windows of one side on one body."""

    features: np.ndarray
    activity: np.ndarray
    clip: np.ndarray
    subject: np.ndarray
    is_test: np.ndarray


def main() -> None:
    """Rank both sides on every body, and print how they agree."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("generated", type=Path)
    parser.add_argument("real", type=Path)
    parser.add_argument("--patches", type=int, default=128)
    parser.add_argument("--bodies", default=BODIES)
    asked = parser.parse_args()
    average = Body.bundled()
    patches = sample_patches(average, asked.patches)
    names = {generated: name for generated, (name, _) in PAIRS.items()}
    generated = _motions(asked.generated, names, average)
    real = _motions(asked.real, {theirs: name for name, theirs in PAIRS.values()}, average)
    print(f"generated: {len(generated)} clips; HDM05: {len(real)} clips; {asked.patches} patches\n")
    print(f"| {' | '.join(['body', 'rho of mean F1', *names.values(), *LAST_COLUMNS])} |")
    print("| --- " * (2 + len(names) + len(LAST_COLUMNS)) + "|")
    pooling = Pooling.on(average, patches)
    for name, body in parse_bodies(asked.bodies):
        sides = [_side(motions, body, average, patches) for motions in (generated, real)]
        print(_row(name, patches, pooling, sides, list(names.values())), flush=True)


def _motions(folder: Path, names: dict[str, str], body: Body) -> list[Motion]:
    found = []
    for clip in read_library(folder, folder / "labels.csv").clips:
        if clip.activity not in names:
            continue
        try:
            motion = load_clip(clip, body)[1]
        except UnusableMotion as error:
            print(f"{clip.file}: {error}")
            continue
        found.append(motion.labelled(names[clip.activity], clip.subject, clip.name))
    return found


def _side(motions: list[Motion], body: Body, average: Body, patches: PatchSet) -> Side:
    """As worn by a body, with a watch's errors."""
    features, rows, is_test = [], [], []
    for motion in motions:
        moved = replace(motion, pelvis=motion.pelvis * (body.height / average.height))
        recording = record_motion(body, patches, moved, sensor=preset("watch"))
        try:
            windows = cut_windows(recording, WindowSpec())
        except ValueError:
            continue
        features.append(window_features(windows.signals, recording.rate))
        is_test.append(windows.is_test)
        rows += [(motion.activity, motion.clip, motion.subject)] * len(windows.is_test)
    activity, clip, subject = np.array(rows).T
    return Side(np.concatenate(features), activity, clip, subject, np.concatenate(is_test))


def _row(name: str, patches: PatchSet, pooling: Pooling, sides: list[Side], activities: list[str]) -> str:
    maps = [_ranked(side, activities, pooling) for side in sides]
    rho = [spearmanr(*(found.expected_mean for found in maps))[0]]
    rho += [spearmanr(*(found.expected_f1[:, a] for found in maps))[0] for a in range(len(activities))]
    across = [_taught(*pair, activities) for pair in (sides, sides[::-1])]
    best = int(maps[0].expected_mean.argmax())
    cells = [name, *(f"{value:.2f}" for value in rho)]
    cells.append(", ".join(f"{np.sqrt(max(0.0, found.reliability)):.2f}" for found in maps))
    cells += [f"{f1.mean():.2f} ({f1.min():.2f} to {f1.max():.2f})" for f1 in across]
    real = maps[1].expected_mean
    cells.append(f"{patches.names[best]}, {real[best]:.2f}, {real.max():.2f}")
    return "| " + " | ".join(cells) + " |"


def _ranked(side: Side, activities: list[str], pooling: Pooling) -> UtilityMap:
    return utility_map(
        side.features, Protocol(side.activity, side.clip, side.subject, side.is_test, activities), pooling
    )


def _taught(teacher: Side, tested: Side, activities: list[str]) -> np.ndarray:
    """Macro F1 at each patch on the one side of a classifier that learnt from the other, shape (N,)."""
    asked = tested.is_test
    labels = [np.searchsorted(sorted(activities), side.activity) for side in (teacher, tested)]
    fold = np.repeat([ALWAYS_TRAIN, 0], [len(labels[0]), int(asked.sum())])
    truth = labels[1][asked]
    features = np.concatenate([teacher.features, tested.features[asked]])
    named = Ridge().predict_folds(features, np.concatenate([labels[0], truth]), fold, fold == 0)
    counts = ClipUnits(truth, tested.clip[asked], len(activities)).count(named)
    return f1_scores(counts, np.ones((1, len(counts.size))))[0].mean(axis=1)


if __name__ == "__main__":
    main()
