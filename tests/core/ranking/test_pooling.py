# SPDX-License-Identifier: GPL-3.0-or-later
"""Pooling over the skin: constants stay, noise goes, sides are told apart where they differ."""

import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.patches.patches import sample_patches
from w2w.core.patches.strip_graph import SkinDistances
from w2w.core.ranking.pooling import LEAST, LOST, MIRROR_M, UNLEARNED, WIDTH_M, Pooling, _kernel

pytestmark = pytest.mark.later

N = 128


@pytest.fixture(scope="module")
def body():
    return Body.bundled()


@pytest.fixture(scope="module")
def patches(body):
    return sample_patches(body, N)


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
    np.testing.assert_allclose(pooling.apply(np.full((2, N), 0.7)), 0.7)


@pytest.mark.parametrize("count", [N, 12, 3])
def test_patches_too_far_to_be_measured_weigh_nothing(body, count):
    patches = sample_patches(body, count)
    far = SkinDistances.of(body, patches.vertices)
    assert (far.between > LOST * WIDTH_M).mean() > 0.5
    every = Pooling(_kernel(far.between, WIDTH_M), _kernel(far.to_mirror_image, MIRROR_M))
    maps = np.random.default_rng(5).random((30, count))
    assert np.isfinite(every.apply(maps)).all()
    np.testing.assert_array_equal(Pooling.on(body, patches).apply(maps), every.apply(maps))


def test_of_noise_between_sides_the_least_is_kept(pooling):
    assert pooling.side_share(halves(np.full((3, N), 0.5), 0.1, n=40)) < 0.15


def test_pooling_brings_a_noisy_map_nearer_the_truth(body, patches, pooling):
    real = truth(body, patches)
    share = pooling.side_share(halves(real, 0.3))
    noisy = real + 0.3 * np.random.default_rng(2).normal(size=(12, *real.shape))
    pooled = np.array([pooling.apply(one, share) for one in noisy])
    assert np.abs(pooled - real).mean() < 0.7 * np.abs(noisy - real).mean()


def test_a_one_sided_activity_keeps_its_side(body, patches, pooling):
    real = truth(body, patches)
    share = pooling.side_share(halves(real, 0.1))
    assert share > 0.7
    right = body.vertices[patches.vertices, 0] < -0.3
    left = body.vertices[patches.vertices, 0] > 0.3
    both, one = pooling.apply(real, share)
    assert one[right].mean() - one[left].mean() > 0.7 * (real[1, right].mean() - real[1, left].mean())
    assert abs(both[right].mean() - both[left].mean()) < 0.05


@pytest.mark.parametrize("share", [LEAST, UNLEARNED])
def test_a_side_keeps_its_lead_where_halves_do_not_show_it(body, patches, pooling, share):
    right = body.vertices[patches.vertices, 0] < -0.3
    left = body.vertices[patches.vertices, 0] > 0.3
    one = pooling.apply(truth(body, patches), share)[1]
    assert one[right].mean() > one[left].mean()


def test_nothing_learned_is_the_usual_share(pooling):
    assert pooling.side_share([]) == UNLEARNED


def test_without_skin_a_map_stays_as_it_is():
    maps = np.random.default_rng(3).normal(size=(1, N))
    np.testing.assert_allclose(Pooling.none(N).apply(maps), maps, atol=1e-12)
