# SPDX-License-Identifier: GPL-3.0-or-later
"""Agreement of rankings: known coefficients, exact chances, honest intervals."""

from itertools import permutations

import numpy as np
import pytest
from scipy.stats import spearmanr

from w2w.core.ranking.agreement import bootstrap_interval, rank_agreement, spearman_rows


def test_spearman_equals_scipy_with_ties():
    rng = np.random.default_rng(0)
    first, second = rng.integers(0, 6, size=(2, 40, 11)).astype(float)
    expected = [spearmanr(a, b).statistic for a, b in zip(first, second, strict=True)]
    np.testing.assert_allclose(spearman_rows(first, second), expected)


def test_five_places_have_the_exact_permutation_chance_and_a_coarse_step():
    real, simulated = np.array([0.9, 0.8, 0.7, 0.6, 0.5]), np.array([0.8, 0.9, 0.7, 0.6, 0.5])
    result = rank_agreement(real, simulated)
    assert result.spearman == pytest.approx(0.9)
    assert result.step == pytest.approx(0.1)
    assert result.kendall == pytest.approx(0.8)
    as_high = sum(spearmanr(p, simulated).statistic >= 0.9 - 1e-12 for p in permutations(real))
    assert result.p_value == pytest.approx(as_high / 120)


@pytest.mark.slow
def test_noise_has_no_agreement_and_its_p_values_are_even():
    rng = np.random.default_rng(4)
    p_values = [rank_agreement(*rng.normal(size=(2, 6)), resamples=100, seed=k).p_value for k in range(120)]
    assert 0.4 < np.mean(p_values) < 0.62
    assert np.mean(np.array(p_values) <= 0.05) <= 0.11


@pytest.mark.slow
def test_interval_over_places_covers_the_truth():
    rng = np.random.default_rng(5)
    truth = 6 / np.pi * np.arcsin(0.8 / 2)
    covered = 0
    for trial in range(40):
        first = rng.normal(size=60)
        second = 0.8 * first + 0.6 * rng.normal(size=60)
        result = rank_agreement(first, second, resamples=100, seed=trial)
        covered += result.low <= truth <= result.high
    assert covered >= 34


def test_samples_of_the_scores_widen_the_interval_with_their_noise():
    rng = np.random.default_rng(6)
    score = np.linspace(0.2, 0.9, 50)
    width = []
    for noise in (0.01, 0.2):
        samples = score + noise * rng.normal(size=(400, 50))
        result = rank_agreement(score, score, first_samples=samples, second_samples=samples[::-1])
        assert result.spearman == pytest.approx(1.0)
        width.append(result.high - result.low)
    assert width[0] < 0.02 < width[1]


def test_an_interval_spans_the_estimate_and_undoes_what_resampling_shifts():
    draws = np.random.default_rng(8).normal(0.4, 0.1, 4000)
    low, high = bootstrap_interval(0.4, draws)
    assert (low, high) == pytest.approx((0.204, 0.596), abs=0.02)
    assert bootstrap_interval(0.5, draws)[1] > high + 0.08  # the estimate lies one spread above its draws
    low, high = bootstrap_interval(0.9, draws)
    assert low == pytest.approx(0.204, abs=0.02)
    assert high == 0.9
    assert np.isnan(bootstrap_interval(0.4, np.full(3, np.nan))).all()


def test_same_seed_same_result():
    rng = np.random.default_rng(7)
    first, second = rng.normal(size=(2, 30))
    assert rank_agreement(first, second, seed=3) == rank_agreement(first, second, seed=3)


def test_constant_scores_agree_with_nothing():
    result = rank_agreement(np.ones(5), np.arange(5.0))
    assert np.isnan([result.spearman, result.kendall, result.low, result.p_value]).all()


def test_what_cannot_be_ranked_is_refused():
    with pytest.raises(ValueError, match="three are needed"):
        rank_agreement([1, 2], [2, 1])
    with pytest.raises(ValueError, match="same patches or sites"):
        rank_agreement([1, 2, 3], [2, 1])
