# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest

from w2w.core.findings.pilot import by_chance, half_width, learned, levelled, macro_f1, width_with


def test_level_moves_by_activity_and_stays_within_0_and_1() -> None:
    expected = np.array([[0.9, 0.5], [0.7, 0.1]])
    found = levelled(expected, np.array([-0.5, 0.9]))
    assert found.tolist() == [[pytest.approx(0.5), 1.0], [pytest.approx(0.3), pytest.approx(0.82)]]


def test_two_people_have_the_errors_of_beginners() -> None:
    assert learned(np.array([0.5]), 2) == pytest.approx(0.7)
    assert learned(np.array([0.5]), 5) == pytest.approx(0.5)


def test_interval_is_narrower_with_more_people_more_places_and_at_the_place_itself() -> None:
    few, many = np.array([0.5, 0.7, 0.9]), np.tile([0.5, 0.7, 0.9], 4)
    assert half_width(few, 1) > half_width(many, 1) > half_width(many, 2) > half_width(many, 1, at_worn=True)
    assert half_width(few, 1) == pytest.approx(width_with(few.std(ddof=1), 3, 1))


def test_labels_dealt_by_chance_reach_no_more_than_chance() -> None:
    rng = np.random.default_rng(3)
    truth = np.repeat(rng.integers(0, 4, 200), 3)
    clip = np.repeat(np.arange(200), 3)
    right = by_chance(truth, truth, clip, 4)
    assert 0.25 < right < 0.4 < macro_f1(truth, truth, 4) == 1.0
    guessed = np.repeat(rng.permutation(truth[::3]), 3)
    assert macro_f1(truth, guessed, 4) <= right
