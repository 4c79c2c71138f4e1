# SPDX-License-Identifier: GPL-3.0-or-later
"""Pooling over the skin: constants stay, noise goes, sides are told apart where they differ."""

import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.pooling import Pooling

N = 128


@pytest.fixture(scope="module")
def body():
    return Body.bundled()


@pytest.fixture(scope="module")
def patches(body):
    return sample_patches(body, N, mode="fast")


@pytest.fixture(scope="module")
def pooling(body, patches):
    return Pooling.on(body, patches)


def truth(body, patches):
    """Two activities: one told best at the hands of both sides, one on the right alone (-x)."""
    place = body.vertices[patches.vertices]
    out = np.abs(place[:, 0]) / np.abs(place[:, 0]).max()
    return np.stack([out, np.where(place[:, 0] < 0, out, 0.0)])


def halves(maps, noise, n=4, seed=0):
    rng = np.random.default_rng(seed)
    return [tuple(maps + noise * rng.normal(size=maps.shape) for _ in range(2)) for _ in range(n)]


def test_a_constant_stays_as_it_is(pooling):
    shares = pooling.learn([], 2)
    np.testing.assert_allclose(pooling.apply(np.full((2, N), 0.7), shares), 0.7)


def test_of_noise_next_to_nothing_is_kept(pooling):
    shares = pooling.learn(halves(np.full((3, N), 0.5), 0.1), 3)
    noise = np.random.default_rng(1).normal(size=(3, N))
    assert pooling.apply(noise, shares).std() < 0.1 * noise.std()


def test_pooling_brings_a_noisy_map_nearer_the_truth(body, patches, pooling):
    real = truth(body, patches)
    shares = pooling.learn(halves(real, 0.3), 2)
    noisy = real + 0.3 * np.random.default_rng(2).normal(size=real.shape)
    assert np.abs(pooling.apply(noisy, shares) - real).mean() < 0.6 * np.abs(noisy - real).mean()


def test_a_one_sided_activity_keeps_its_side(body, patches, pooling):
    real = truth(body, patches)
    shares = pooling.learn(halves(real, 0.3), 2)
    right = body.vertices[patches.vertices, 0] < -0.3
    left = body.vertices[patches.vertices, 0] > 0.3
    both, one = pooling.apply(real, shares)
    assert one[right].mean() - one[left].mean() > 0.5 * (real[1, right].mean() - real[1, left].mean())
    assert abs(both[right].mean() - both[left].mean()) < 0.05


def test_a_side_keeps_its_lead_where_nothing_could_be_learned(body, patches, pooling):
    right = body.vertices[patches.vertices, 0] < -0.3
    left = body.vertices[patches.vertices, 0] > 0.3
    one = pooling.apply(truth(body, patches), pooling.learn([], 2))[1]
    assert one[right].mean() > one[left].mean()


def test_without_skin_a_map_is_shrunk_and_nothing_else():
    pooling = Pooling.none(N)
    maps = np.random.default_rng(3).normal(size=(1, N))
    found = pooling.apply(maps, np.ones((2, 1)))
    np.testing.assert_allclose(found - maps.mean(), maps - maps.mean(), atol=1e-12)
