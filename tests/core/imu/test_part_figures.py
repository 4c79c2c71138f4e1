# SPDX-License-Identifier: GPL-3.0-or-later
"""A form's figures are those of a sensor's file, in a datasheet's units and the file's ranges."""

import json
from dataclasses import replace

import numpy as np
import pytest

from w2w.core.imu.presets import preset, read_sensor
from w2w.core.imu.sensor_fields import FIGURES

WRITTEN = {
    "acc_range": "16 g", "acc_noise": "120 ug/sqrt(Hz)", "acc_bias": "12.5 mg", "acc_drift": "40 ug",
    "gyr_range": "1000 dps", "gyr_noise": "5 mdps/sqrt(Hz)", "gyr_bias": "0.8 deg/s", "gyr_drift": "8 deg/h",
    "misalignment": "3 deg",
}  # fmt: skip


def test_figures_given_one_by_one_are_the_sensor_of_the_file(tmp_path):
    content = {"name": "mine", "like": "bmi270"}
    model = replace(preset("bmi270"), name="mine")
    for name, figure in FIGURES.items():
        value, _, unit = WRITTEN[name].partition(" ")
        inside = content.setdefault(figure.kind, {}) if figure.kind else content
        inside[figure.field] = WRITTEN[name]
        model = figure.given(model, np.float32(value))  # as a form keeps it
        assert unit in (figure.unit, "dps", "deg")
        assert figure.of(model) == pytest.approx(float(value))
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(content))
    assert model == read_sensor(path)


def test_nothing_switches_a_range_off_and_what_cannot_be_is_refused():
    model = FIGURES["acc_range"].given(preset("bmi270"), 0.0)
    assert model.accelerometer.full_scale is None
    assert FIGURES["acc_range"].of(model) == 0
    with pytest.raises(ValueError, match=r"'Misalignment \(°\)' must be 0 to 90 deg"):
        FIGURES["misalignment"].given(model, 91.0)


@pytest.mark.parametrize("figure", FIGURES.values(), ids=FIGURES)
def test_the_highest_value_is_the_files(figure):
    model = figure.given(preset("ideal"), figure.most * (1 - 1e-6))
    assert figure.of(model) == pytest.approx(figure.most, rel=1e-5)
    with pytest.raises(ValueError, match="must be"):
        figure.given(model, figure.most * 1.01)
