# SPDX-License-Identifier: GPL-3.0-or-later
"""Near moments are found among many as by comparing all with all."""

import numpy as np

from w2w.core.motion.signature import REACH, Moments, candidates


def in_threes(rng, threes, levels, width):
    """Moments of as many clips, one each: three of a level about `REACH` apart."""
    places = rng.normal(scale=3, size=(threes, width)) * np.linspace(2, 0.2, width)
    prints = np.repeat(places, 3, axis=0) + rng.normal(
        scale=0.7 * REACH / np.sqrt(width), size=(3 * threes, width)
    )
    level = np.repeat(rng.integers(levels, size=threes), 3).astype(np.int32)
    clip = rng.permutation(3 * threes).astype(np.int32)
    return Moments(level, clip, clip.astype(np.float32), prints.astype(np.float16))


def near_by_all(moments):
    prints = moments.prints.astype(float)
    near = np.linalg.norm(prints[:, None] - prints, axis=2) <= REACH
    near &= (moments.level[:, None] == moments.level) & (moments.clip[:, None] != moments.clip)
    return {(moments.clip[i], moments.clip[j]) for i, j in np.argwhere(near)}


def test_each_near_pair_is_found_and_no_other():
    rng = np.random.default_rng(0)
    for width in (9, 45):
        moments = in_threes(rng, 400, 3, width)
        expected = near_by_all(moments)
        pairs = candidates(Moments.joined([moments]), Moments.joined([moments]))
        assert set(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)) == expected
        assert 200 < len(expected) < 2400  # some of the three are too far apart
        np.testing.assert_array_equal(pairs.moment, pairs.first)
        np.testing.assert_array_equal(pairs.other, pairs.second)


def test_a_level_that_the_others_lack_has_no_near_moments():
    rng = np.random.default_rng(1)
    low, high = in_threes(rng, 4, 1, 9), in_threes(rng, 4, 1, 9)
    high = Moments(high.level + 1, high.clip, high.frame, low.prints)
    pairs = candidates(Moments.joined([low]), Moments.joined([high]))
    assert not len(pairs.first)
