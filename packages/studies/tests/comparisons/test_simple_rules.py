# SPDX-License-Identifier: GPL-3.0-or-later
"""What simple rules lose, where it is known."""

from types import SimpleNamespace

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w_studies.comparisons.simple_rules import BELT, ENERGY, GENERAL, WRIST, general, regrets

SITES = ("belt", "left wrist", "right wrist", "ankle")


def found(*f1: float, sites: tuple[str, ...] = SITES) -> SimpleNamespace:
    return SimpleNamespace(sites=sites, real=SimpleNamespace(mean=np.array(f1)))


def moving(*amplitudes: float) -> ImuRecording:
    """Sensors on four regions, each shaken along gravity."""
    acc = np.zeros((50, 4, 3))
    acc[..., 2] = 9.8 + np.sin(np.arange(50))[:, None] * amplitudes
    sites = ("left hip 3", "left wrist dorsal 2", "right wrist dorsal", "right ankle front")
    return ImuRecording(acc, np.zeros_like(acc), 50.0, sites=sites)


def test_each_rule_loses_what_its_site_lacks_of_the_best():
    lost = regrets(found(0.5, 0.7, 0.9, 0.6), [moving(1, 1, 1, 4)], None)
    assert lost == pytest.approx({BELT: 0.4, WRIST: 0.1, GENERAL: 0.4, ENERGY: 0.3})  # wrists: either


def test_sensors_of_a_site_count_together_and_a_habit_needs_a_site():
    site_of = np.array([0, 1, 1, 2])
    of_sites = found(0.9, 0.6, 0.8, sites=("neck", "arms", "ankle"))
    lost = regrets(of_sites, [moving(1, 2, 6, 3)], site_of)
    assert lost == pytest.approx({GENERAL: 0.0, ENERGY: 0.3})


def test_hips_are_generally_better_than_wrists_and_ankles():
    known = general()
    assert known["hip"] > known["wrist dorsal"] > known["ankle back"]
