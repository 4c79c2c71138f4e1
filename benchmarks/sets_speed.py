# SPDX-License-Identifier: GPL-3.0-or-later
"""How long sets to wear together take: one more sensor, six of them, the promise, and every pair.

    python -m benchmarks.sets_speed RESULTS [--pairs 8]

The baseline is the classifier trained anew on the features of each set side by side, as `w2w place` tests a
chosen set: for a few candidates, times their number. Pairs are timed for a few first patches with all others.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from w2w.core.clip_ranking import set_tests
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.pooling import Pooling
from w2w.core.results_folder import StudyResults
from w2w.core.selection.joint import LARGEST_SET, choose_together, grow
from w2w.core.selection.terms import Terms

BASELINE_CANDIDATES = 4


def timed(name: str, work: Callable[[], object]) -> tuple[float, object]:
    start = time.perf_counter()
    found = work()
    seconds = time.perf_counter() - start
    print(f"{name}: {seconds:.2f} s", flush=True)
    return seconds, found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("results", type=Path)
    parser.add_argument("--pairs", type=int, default=8)
    given = parser.parse_args()
    study = StudyResults.load(given.results)
    config, labels, utility = study.config(), study.labels(), study.utility
    pooling = Pooling.on(study.body(), study.patches)
    inputs = study.inputs("ridge")
    _, tests = timed("preparing", lambda: set_tests(inputs, labels, config, pooling))
    n_patches = len(utility.mean)
    terms = Terms.checked(utility.f1, None, None, (), None)
    best = int(utility.expected_mean.argmax())
    others = np.setdiff1d(np.arange(n_patches), [best])
    with threadpool_limits(1):
        one_more, _ = timed(f"{len(others)} second sensors", lambda: tests.whole.added([best], others, False))
    timed(f"{LARGEST_SET} sensors", lambda: grow(tests.whole, terms, LARGEST_SET, utility.expected_mean))
    expected = (utility.expected_mean, utility.expected_low, utility.expected_high)
    timed("the choice with its promise", lambda: choose_together(tests, expected, terms, 1.0))
    with threadpool_limits(1):
        firsts = np.linspace(0, n_patches - 1, given.pairs).astype(int)
        pairs, _ = timed(
            f"{given.pairs * n_patches} pairs",
            lambda: [tests.whole.added([first], np.arange(n_patches), False) for first in firsts],
        )
    all_pairs = pairs / (given.pairs * n_patches) * n_patches * (n_patches - 1) / 2
    print(f"every pair of {n_patches}: {all_pairs:.0f} s by that")

    def side_by_side() -> None:
        folds = {name: number for number, name in enumerate(sorted(set(labels.activity.tolist())))}
        true = np.array([folds[name] for name in labels.activity.tolist()])
        motion = np.unique(labels.motion, return_inverse=True)[1]
        first = inputs.places(best, best + 1)
        for candidate in others[:BASELINE_CANDIDATES]:
            both = np.concatenate([first, inputs.places(candidate, candidate + 1)], axis=2)
            Ridge(alphas=(0.1,)).predict_folds(both, true, motion % config.folds, labels.is_test)

    baseline, _ = timed(
        f"baseline: {BASELINE_CANDIDATES} second sensors, features side by side", side_by_side
    )
    per_set = baseline / BASELINE_CANDIDATES * len(others)
    print(f"one more sensor takes {one_more / per_set:.2f} of the baseline's time")


if __name__ == "__main__":
    main()
