# SPDX-License-Identifier: GPL-3.0-or-later
"""What multi3net loses by its size: the default and the published sizes on the paper's 11 placements.

    python -m benchmarks.multi3net_sizes RESULTS [--side left] [--folds 5] [--epochs 300] [--work FOLDER]

RESULTS is the folder of a finished `w2w run`. Prints macro F1 of each placement, the mean, and the processor
seconds each size took. Fewer folds test fewer clips, the same ones for both sizes: an activity counts where
one of its clips is tested. FOLDER keeps what is finished.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from w2w.core.patches.naming import DEFAULT_SIDE
from w2w.core.ranking.f1 import ClipUnits, clip_resamples, f1_scores
from w2w.core.ranking.utility import UtilityMap
from w2w.core.study.results import StudyResults
from w2w.studies.classifiers.multi3net.classifier import Multi3Net
from w2w.studies.placements.placement_patches import placement_patches

from .classifier_agreement import RESAMPLES, SomeFolds, rank_again


def macro_f1(utility: UtilityMap, tested: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean F1 of the activities among the tested windows, by place, and of bootstrap samples of the clips."""
    truth = utility.truth[tested]
    seen = np.unique(truth)
    count = ClipUnits(truth, utility.clip[tested], len(utility.activities)).count(utility.predictions[tested])
    weights = clip_resamples(count.activity, RESAMPLES, np.random.default_rng(0))
    whole = np.ones((1, weights.shape[1]), dtype=weights.dtype)
    return tuple(np.nan_to_num(f1_scores(count, w))[..., seen].mean(axis=-1) for w in (whole, weights))


def main() -> None:
    """Rank the placements by both sizes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--side", choices=("left", "right"), default=DEFAULT_SIDE)
    parser.add_argument("--folds", type=int, default=5, help="folds that are tested")
    parser.add_argument("--epochs", type=int, default=Multi3Net.full().epochs, help="of the published size")
    parser.add_argument("--work", type=Path)
    options = parser.parse_args()
    study = StudyResults.load(options.results)
    found = placement_patches(study.body(), study.patches, options.side)
    places = {name: near.patch for name, near in found.items()}
    sizes = {"default": Multi3Net(), "published": Multi3Net.full(epochs=options.epochs)}
    points, samples = {}, {}
    for name, model in sizes.items():
        started = time.process_time()
        if options.work is not None:
            model = replace(model, checkpoints=options.work / name)
        some = SomeFolds(model, tuple(range(options.folds)))
        utility = rank_again(study, some, list(places.values()), None)
        print(f"{name}: {time.process_time() - started:.0f} processor seconds", flush=True)
        points[name], samples[name] = macro_f1(utility, some.tested)
    print(f"{some.tested.sum()} of {len(some.tested)} test windows")
    print(f"{'':20}" + "".join(f"{name:>12}" for name in sizes))
    for row, place in enumerate(places):
        print(f"{place:20}" + "".join(f"{score[0, row]:12.3f}" for score in points.values()))
    print(f"{'mean':20}" + "".join(f"{score.mean():12.3f}" for score in points.values()))
    lost = samples["default"].mean(axis=1) - samples["published"].mean(axis=1)
    low, high = np.quantile(lost, [0.025, 0.975])
    print(f"default less published, 95 % of resamples of the clips: {low:.3f} to {high:.3f}")


if __name__ == "__main__":
    main()
