# SPDX-License-Identifier: GPL-3.0-or-later
"""A report of a comparison says which errors the simulated sensors have."""

from dataclasses import replace

from w2w.core.imu.presets import preset
from w2w.core.imu.sensor import SensorModel
from w2w_studies.comparisons.site_simulator import error_sentence


def test_a_part_without_errors_is_said_to_have_none():
    assert "free of noise" in error_sentence(SensorModel.ideal())
    assert error_sentence(replace(SensorModel.ideal(), name="mine")) == error_sentence(SensorModel.ideal())
    assert error_sentence(preset("bmi270")).startswith(
        "Simulated sensors have the errors of the bmi270. Loose"
    )
