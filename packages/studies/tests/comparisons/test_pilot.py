# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest

from w2w_studies.comparisons.pilot import PARTS, Simulated, Worn, half_of
from w2w_studies.comparisons.pilot_rules import cases, errors, frozen, mean_abs, no_pilot, regrets, rules

ACTIVITIES = np.array(["walk", "run", "sit"])


def made(shift: float, site: float = 0.0) -> tuple[Simulated, Worn]:
    """Four sites of which people reach so much less than is expected, and each site so much off besides."""
    rng = np.random.default_rng(1)
    expected = np.tile(0.8 + 0.04 * rng.normal(size=(4, 3)), (2, 1, 1))
    worn = expected[0] - shift + site * np.array([1, -1, 1, -1])[:, None]
    people = np.array([6, 2, 3])
    by_person = worn.mean(axis=1) + 0.02 * rng.normal(size=(6, 4))
    distance = 1 - np.eye(4)
    return (
        Simulated(ACTIVITIES, expected, distance),
        Worn(ACTIVITIES, np.stack([worn] * 3), people, by_person, worn),
    )


def test_halves_of_the_people_are_apart_and_are_everyone() -> None:
    people = [f"p{n}" for n in range(7)]
    parts = [half_of(people, part) for part in PARTS]
    assert [len(part) for part in parts] == [4, 3]
    assert sorted([*parts[0], *parts[1]]) == people


def test_a_level_that_is_off_is_mended_and_the_order_stays() -> None:
    one = cases(*made(0.2))[0]
    without, rule = mean_abs([errors(one, no_pilot)]), frozen(one)
    assert without == pytest.approx(0.2)
    assert mean_abs([rule.errors]) == pytest.approx(0.04, abs=0.01)
    assert rule.inside.all()
    assert regrets(one, rules()["constant shift"]).max() == 0


def test_sites_that_differ_make_a_shift_wrong_and_a_shrunk_one_less_so() -> None:
    one = cases(*made(0.0, 0.1))[0]
    shifted, shrunk = (
        mean_abs([errors(one, rules()[name])]) for name in ("constant shift", "shrunk shift 0.5")
    )
    assert mean_abs([errors(one, no_pilot)]) < shrunk < shifted


def test_two_peoples_errors_are_taken_for_those_of_beginners() -> None:
    one = cases(*made(0.2))[0]
    assert frozen(one, people=2).errors.mean() > frozen(one).errors.mean()
