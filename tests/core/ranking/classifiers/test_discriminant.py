# SPDX-License-Identifier: GPL-3.0-or-later
"""Solved for features or for windows, a discriminant is what its definition says."""

import numpy as np
import pytest

from w2w.core.ranking.classifiers.discriminant import FEW, Discriminant, few

A = 4
RIDGES = np.array([0.01, 0.3, 10.0])


def by_definition(inputs, member, ridge, tested):
    """Scores in double precision, by the inverse of the matrix of features."""
    windows = member.sum(axis=0)
    means = member.T @ inputs / np.maximum(windows, 1)[:, None]
    within = inputs - member @ means
    scale = np.sqrt((within**2).mean(axis=0))
    scale[scale < 1e-6] = np.inf
    within, means = within / scale, means / scale
    matrix = within.T @ within / len(inputs) + ridge * np.eye(inputs.shape[1])
    slopes = np.linalg.solve(matrix, means.T).T
    offset = np.where(windows > 0, -0.5 * (means * slopes).sum(axis=1), -np.inf)
    return tested / scale @ slopes.T + offset


@pytest.mark.parametrize("width", [6, 40, 90])
@pytest.mark.parametrize("way", ["features", "windows"])
def test_scores_equal_the_definition(width, way):
    rng = np.random.default_rng(width)
    member = np.eye(A)[np.arange(48) % (A - 1)]  # the last class has no windows
    inputs = rng.normal(size=(48, width)) @ rng.normal(size=(width, width)) + 3 * rng.normal(size=width)
    inputs += member @ rng.normal(size=(A, width)) * 5
    inputs -= inputs.mean(axis=0)
    inputs[:, 1] = 0.0  # never varies
    tested = rng.normal(size=(10, width))
    if way == "features":
        windows = member.sum(axis=0)
        means = member.T @ inputs / np.maximum(windows, 1)[:, None]
        within = inputs - member @ means
        sums = (within.T @ within, (inputs**2).sum(axis=0), means, windows, RIDGES)
        of_another = (np.eye(width), np.ones(width), 0 * means, np.ones(A), RIDGES[::-1])
        trained = Discriminant.by_features(
            *(np.array(pair, dtype=np.float32) for pair in zip(of_another, sums, strict=True))
        )
    else:
        trained = Discriminant.by_windows(inputs[None].astype(np.float32), member.astype(np.float32), RIDGES)
    found = trained.scores(int(way == "features"), tested.astype(np.float32)).transpose(1, 2, 0)
    for scores, ridge in zip(found, RIDGES, strict=True):
        wanted = by_definition(inputs, member, ridge, tested)
        assert np.isneginf(scores[:, -1]).all()
        largest = np.abs(wanted[:, :-1]).max()
        np.testing.assert_allclose(scores[:, :-1], wanted[:, :-1], rtol=0, atol=1e-3 * largest)


def test_few_windows_are_told_by_the_number_of_features():
    np.testing.assert_array_equal(few(np.array([10, FEW * 100 + 1]), 100), [True, False])
