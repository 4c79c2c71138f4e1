# SPDX-License-Identifier: GPL-3.0-or-later
"""A set's setting is chosen by the other sets, never by itself."""

import pytest

from w2w.core.imu.sensor import SensorModel
from w2w.studies.validation.mhad import MHAD
from w2w.studies.validation.tuning import SETTINGS, Result, Setting, best_setting, leave_one_set_out


def result(rho, regret=0.01):
    return Result(rho, rho, rho, regret)


SETS = {
    "a": {"as fixed": result(0.2), "soft": result(0.9), "band": result(0.5)},
    "b": {"as fixed": result(0.4), "soft": result(0.3), "band": result(0.6)},
    "c": {"as fixed": result(0.5), "soft": result(0.1), "band": result(0.7)},
}


def test_the_setting_that_is_best_on_a_set_is_not_chosen_by_it():
    found = leave_one_set_out(SETS)
    assert found["a"].setting == "band"  # soft would be its own choice
    assert found["a"].best == "soft"
    assert found["a"].result == SETS["a"]["band"]
    assert found["a"].fixed == SETS["a"]["as fixed"]
    assert found["a"].hindsight == SETS["a"]["soft"]
    assert found["b"].setting == "band"  # .6 on the others, soft .5
    assert found["c"].setting == "soft"  # .6 on the others, band .55


def test_settings_alike_in_rho_are_told_apart_by_regret_and_then_by_their_order():
    alike = {"as fixed": result(0.5, 0.03), "soft": result(0.5, 0.01), "band": result(0.5, 0.01)}
    assert best_setting([alike]) == "soft"
    assert best_setting([{"as fixed": result(float("nan")), "soft": result(0.0)}]) == "soft"


def test_one_set_cannot_choose_for_itself():
    with pytest.raises(ValueError, match="two at least"):
        leave_one_set_out({"a": SETS["a"]})


def test_a_setting_changes_one_thing_in_a_copy():
    analysis = MHAD.analyses[0]
    for setting in SETTINGS:
        protocol, changed = setting.of(MHAD, analysis)
        assert changed.activities == analysis.activities
        assert (protocol.sensor, changed.cutoff_hz) != (MHAD.sensor, 3.0) or setting.name in (
            "as fixed",
            "sources apart",
        )
    soft = Setting("soft", tissue=(6.0, 0.3, 0.8)).of(MHAD, analysis)[0].sensor
    assert (soft.soft_tissue_hz, soft.accelerometer) == (6.0, MHAD.sensor.accelerometer)
    assert Setting("clean", noise=False).of(MHAD, analysis)[0].sensor == SensorModel.ideal()
