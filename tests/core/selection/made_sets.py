# SPDX-License-Identifier: GPL-3.0-or-later
"""A made library in which two groups of patches complement each other, and what sets are judged by."""

import numpy as np

from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import ExpectedF1
from w2w.core.ranking.weights import mean_over
from w2w.core.selection.constraints import Terms
from w2w.core.selection.set_tests import SetTests

N, D, CLIPS = 12, 6, 12
NAMES = ("crawl", "jump", "run", "sit")


def library(seed=0, told=(0, 1), shuffled=False):
    """Patches 0 to 3 tell crawl from jump alone, 4 to 7 run from sit, the others nothing."""
    rng = np.random.default_rng(seed)
    clip = np.repeat(np.arange(4 * CLIPS), 2)
    activity = np.repeat(np.arange(4), 2 * CLIPS)
    features = rng.normal(size=(len(clip), N, D)) + 0.7 * rng.normal(size=(4 * CLIPS, N, D))[clip]
    side = np.where(activity % 2, 0.9, -0.9)
    for group, patches in enumerate((slice(0, 4), slice(4, 8))):
        if group in told:
            features[:, patches, 0] += np.where(activity // 2 == group, side, 0)[:, None]
            features[:, patches, 1] += 2.0 * (activity // 2 == group)[:, None]
    names = np.array(NAMES)[activity]
    if shuffled:
        names = np.array(NAMES)[rng.permutation(np.repeat(np.arange(4), CLIPS))][clip]
    return features.astype(np.float32), names, clip


def prepare(features, names, clip, subject=None, counts=None):
    every = np.ones(len(clip), dtype=bool)
    protocol = CrossValidation(names, clip, subject, every, NAMES, 3, counts=counts)
    return SetTests.of(features, protocol, Pooling.none(N))


def terms(size=N, allowed=None, required=(), cost=None):
    allowed = np.ones(N, bool) if allowed is None else allowed
    open_patches = np.flatnonzero(allowed)
    cost = np.ones(N) if cost is None else cost
    return Terms(allowed, [np.intersect1d(options, open_patches) for options in required], cost, size)


def alone(found):
    """About what the F1 of each patch on other clips would be: less than on the clips that chose it."""
    mean = 0.8 * mean_over(found.whole.alone, found.weights, 0)
    return ExpectedF1(mean, mean - 0.1, mean + 0.1)
