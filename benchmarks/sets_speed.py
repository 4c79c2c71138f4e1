# SPDX-License-Identifier: GPL-3.0-or-later
"""How long sets to wear together take: one more sensor, six of them, and the promise.

    python -m benchmarks.sets_speed RESULTS

Printed are seconds by the clock and of the processor: on a machine that does other things as well, only the
second say something. The baseline is the classifier trained anew on the features of each set side by side:
for a few candidates, times their number.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.joint_scores import JointScores
from w2w.core.ranking.pooling import Pooling
from w2w.core.selection.constraints import Constraints
from w2w.core.selection.joint import LARGEST_SET, GrownSet, choose_together
from w2w.core.study.ranking import set_tests_of
from w2w.core.study.results import StudyResults

BASELINE_CANDIDATES = 4

ONE_MORE = 24
"""Candidates by which the two ways to add one more sensor are compared, in turn."""


def timed(name: str, work: Callable[[], object]) -> tuple[float, object]:
    """Processor seconds of some work, and what it gives."""
    clock, processor = time.perf_counter(), time.process_time()
    found = work()
    clock, processor = time.perf_counter() - clock, time.process_time() - processor
    print(f"{name}: {clock:.2f} s, of the processor {processor:.2f} s", flush=True)
    return processor, found


def compare_ways(scores: JointScores, order: Sequence[int]) -> None:
    """One more sensor by its features, against by its kernels."""
    candidates = np.setdiff1d(np.arange(scores.n_patches), order)[:ONE_MORE].tolist()
    with threadpool_limits(1):
        for count in range(len(order)):
            spent = {}
            for way in (scores.adding_by_kernels, scores.adding_by_features):
                add = way(order[:count])
                began = time.thread_time()
                list(add(candidates))
                spent[way.__name__] = time.thread_time() - began
            by_kernels, by_features = spent.values()
            print(f"one more than {count}: features take {by_features / by_kernels:.2f} of kernels' time")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("results", type=Path)
    given = parser.parse_args()
    study = StudyResults.load(given.results)
    config, labels, utility = study.config(), study.labels(), study.utility
    pooling = Pooling.on(study.body(), study.patches)
    inputs = study.inputs("ridge")

    def prepared() -> object:
        return set_tests_of(inputs, labels, config, pooling, utility=utility)

    _, tests = timed("preparing", prepared)
    n_patches, n_windows = len(utility.mean), len(labels.activity)
    print(f"{n_patches} patches, {n_windows} windows, {len(utility.activities)} activities")
    terms = Constraints().terms(study.patches)
    best = int(utility.expected_mean.argmax())
    others = np.setdiff1d(np.arange(n_patches), [best])
    compare_ways(tests.whole.scores, [best, *others[:: n_patches // 4]])
    with threadpool_limits(1):
        one_more, _ = timed(f"{len(others)} second sensors", lambda: tests.whole.added([best], others, False))
    timed(
        f"{LARGEST_SET} sensors",
        lambda: GrownSet(tests.whole, terms, utility.expected_mean).up_to(LARGEST_SET),
    )
    timed(
        f"{LARGEST_SET} sensors with their promise",
        lambda: choose_together(prepared(), utility.expected, terms, 1.0),
    )
    print(f"most memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB")

    def side_by_side() -> None:
        folds = {name: number for number, name in enumerate(sorted(set(labels.activity.tolist())))}
        true = np.array([folds[name] for name in labels.activity.tolist()])
        motion = np.unique(labels.motion, return_inverse=True)[1]
        first = inputs.patches(best, best + 1)
        for candidate in others[:BASELINE_CANDIDATES]:
            both = np.concatenate([first, inputs.patches(candidate, candidate + 1)], axis=2)
            Ridge(alphas=(0.1,)).predict_folds(both, true, motion % config.folds, labels.is_test)

    baseline, _ = timed(
        f"baseline: {BASELINE_CANDIDATES} second sensors, features side by side", side_by_side
    )
    per_set = baseline / BASELINE_CANDIDATES * len(others)
    print(f"one more sensor takes {one_more / per_set:.2f} of the baseline's processor time")


if __name__ == "__main__":
    main()
