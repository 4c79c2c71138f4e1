# SPDX-License-Identifier: GPL-3.0-or-later
"""Regret is the real F1 between the really best site and the one that simulation calls best."""

import numpy as np
import pytest

from w2w_studies.validation.regret import lost, regret


def test_the_right_choice_loses_nothing_and_a_wrong_one_what_it_costs():
    real = np.array([[0.9], [0.8], [0.4]])
    assert lost(real, np.array([[0.3], [0.2], [0.1]])) == 0
    assert lost(real, np.array([[0.2], [0.3], [0.1]])) == pytest.approx(0.1)
    assert lost(real, np.array([[0.2], [0.3], [0.3]])) == pytest.approx(0.3)  # one as likely as the other


def test_activities_are_averaged_and_those_not_drawn_stay_out():
    real = np.array([[0.9, 0.2], [0.5, 0.6]])
    simulated = np.array([[0.4, 0.5], [0.6, 0.4]])
    assert lost(real, simulated) == pytest.approx(0.4)
    real[:, 1] = np.nan
    assert lost(real, simulated) == pytest.approx(0.4)
    simulated[:, 0], real[:, 1] = np.nan, (0.2, 0.6)
    assert lost(real, simulated) == pytest.approx(0.4)


def test_the_interval_holds_choices_that_other_clips_would_have_made():
    rng = np.random.default_rng(0)
    real, simulated = np.array([[0.9], [0.8], [0.4]]), np.array([[0.70], [0.69], [0.1]])
    samples = simulated + rng.normal(0, 0.02, (2000, 3, 1))
    found = regret(real, simulated, np.tile(real, (2000, 1, 1)), samples)
    assert (found.lost, found.low, found.high) == pytest.approx((0.0, 0.0, 0.1))
    assert found.at_random == pytest.approx(0.2)
