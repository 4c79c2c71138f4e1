# SPDX-License-Identifier: GPL-3.0-or-later
"""Sites that recognise activities equally well on both sides agree, and those that do not do not."""

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.core.windows.windows import WindowSpec
from w2w_studies.validation.site_windows import site_windows
from w2w_studies.validation.sites import of_the_whole, validate_sites

RATE, SECONDS = 25.0, 4.0
ACTIVITIES = ("slow", "fast", "turning")
SPEC = WindowSpec(length_s=2.0, stride_s=1.0)
NOISE = {"clear": 0.1, "fair": 1.5, "poor": 4.0, "bad": 8.0, "dead": 40.0}


def recordings(sites, seed, clips=6, activities=ACTIVITIES):
    """Clips in which a site shows the activity the better the less noise it has."""
    rng = np.random.default_rng(seed)
    time = np.arange(int(RATE * SECONDS)) / RATE
    made = []
    for activity in activities:
        for number in range(clips):
            pace = {"slow": 0.8, "fast": 2.0, "turning": 0.8}[activity] * rng.uniform(0.9, 1.1)
            wave = np.sin(2 * np.pi * pace * time + rng.uniform(0, 6))[:, None, None]
            acc = 2.0 * wave * [1, 0.5, 0] + [0, 0, 9.8]
            gyr = (1.0 if activity == "turning" else 0.2) * wave * [0, 1, 0]
            noise = np.array([NOISE[site] for site in sites])[None, :, None]
            shape = (len(time), len(sites), 3)
            made.append(
                ImuRecording(
                    acc + noise * rng.normal(size=shape), gyr + 0.3 * noise * rng.normal(size=shape), RATE,
                    sites, activity, f"p{number % 4}", f"{activity} {number}",
                )
            )  # fmt: skip
    return made


SITES = tuple(NOISE)


def test_the_same_order_on_both_sides_is_found():
    real, simulated = (site_windows(recordings(SITES, seed), SPEC) for seed in (1, 2))
    found = validate_sites(real, simulated, SITES, ACTIVITIES)
    assert found.mean_rho > 0.8
    assert found.overall.spearman > 0.9
    assert found.mean_p < 0.05
    assert found.mean_low <= found.mean_rho <= found.mean_high
    assert found.ceiling.value > 0.6
    assert set(found.by_activity) == set(ACTIVITIES)
    assert found.cells.low <= found.cells.value <= found.cells.high <= 1
    assert 0.8 < found.cells_ceiling <= 1
    assert found.regret.lost < 0.05
    assert "a sensor loses 0.0" in found.regret_sentence()
    assert "which reaches 0.5" in found.sentence(0.5)
    assert "one swap of neighbours costs an activity's rho 0.10" in found.sentence()


def test_the_ceiling_is_that_of_as_many_other_people():
    rng = np.random.default_rng(0)
    true = rng.normal(size=30000)
    measured = true + rng.normal(0, 1, (2, 2, true.size))  # two groups, each of two halves
    halves = np.corrcoef(measured[0])[0, 1]
    groups = np.corrcoef(measured.mean(axis=1))[0, 1]
    assert of_the_whole(halves) == pytest.approx(groups, abs=0.02)
    assert of_the_whole(-0.3) == 0


def test_background_is_told_apart_from_and_not_compared():
    real, simulated = (site_windows(recordings(SITES, seed), SPEC) for seed in (1, 2))
    every = validate_sites(real, simulated, SITES, ACTIVITIES)
    found = validate_sites(real, simulated, SITES, ACTIVITIES, background=("turning",))
    assert tuple(found.by_activity) == found.real.activities == ("slow", "fast")
    np.testing.assert_array_equal(found.real.f1, every.real.f1[:, :2])
    assert found.real.n_windows == every.real.n_windows
    with pytest.raises(ValueError, match="nothing but background"):
        validate_sites(real, simulated, SITES, ACTIVITIES, background=ACTIVITIES)


def test_another_classifier_takes_what_it_takes():
    sides = [site_windows(recordings(SITES[:3], seed, clips=4), SPEC) for seed in (1, 2)]
    found = validate_sites(*sides, SITES[:3], ACTIVITIES, folds=2, classifier="trees")
    assert (found.real.classifier, found.simulated.classifier) == ("trees", "trees")
    assert found.real.mean[0] > 0.8


def test_the_reverse_order_disagrees():
    real = site_windows(recordings(SITES, 1), SPEC)
    simulated = site_windows(recordings(SITES[::-1], 2), SPEC)
    found = validate_sites(real, simulated, SITES, ACTIVITIES)
    assert found.mean_rho < -0.6
    assert found.mean_p > 0.9
    assert "which is below 0.85" in found.sentence()
    assert found.cells.value < 0
    assert found.regret.lost > found.regret.at_random


def test_sites_that_do_not_differ_have_a_low_ceiling():
    real, simulated = (site_windows(recordings(("clear",) * 5, seed), SPEC) for seed in (1, 2))
    found = validate_sites(real, simulated, ("a", "b", "c", "d", "e"), ACTIVITIES)
    assert found.ceiling.value < 0.5
    assert found.real.f1.min() > 0.95


def test_only_what_both_sides_can_test_is_compared():
    real = site_windows(recordings(SITES, 1), SPEC)
    simulated = site_windows(recordings(SITES, 2, activities=("slow", "fast")), SPEC)
    found = validate_sites(real, simulated, SITES, ACTIVITIES, by_subject=(True, False))
    assert found.real.activities == found.simulated.activities == ("slow", "fast")
    assert found.real.protocol.startswith("leave one of 4 subjects out")
    assert found.simulated.protocol.startswith("5-fold")
    assert "turning has no clip" in found.simulated.left_out["turning"]


def test_the_same_seed_gives_the_same_numbers():
    real, simulated = (site_windows(recordings(SITES[:3], seed, clips=3), SPEC) for seed in (1, 2))
    first, second = (validate_sites(real, simulated, SITES[:3], ACTIVITIES, seed=3) for _ in range(2))
    assert first.sentence() == second.sentence()
    assert first.by_activity == second.by_activity
