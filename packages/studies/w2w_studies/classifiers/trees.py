# SPDX-License-Identifier: GPL-3.0-or-later
"""A forest at every patch, by scikit-learn."""

from sklearn.ensemble import ExtraTreesClassifier

from w2w.core.ranking.classifiers.estimator import EstimatorClassifier


def extra_trees(seed: int = 0) -> EstimatorClassifier:
    """Extremely randomised trees, a baseline (Geurts et al. 2006, doi:10.1007/s10994-006-6226-1)."""
    return EstimatorClassifier(ExtraTreesClassifier(100, random_state=seed), name="trees")
