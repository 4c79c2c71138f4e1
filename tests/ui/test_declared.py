# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel's properties have the label, default and limits that a study's parameters declare."""

import numpy as np
import pytest

from w2w.core.parameters import parameters_of
from w2w.core.study.config import StudyConfig
from w2w.ui.panels.properties import W2W_PG_study
from w2w.ui.study.declared import as_given, declared

PROPERTIES = {"patches": "patch_count", "window": "window_s"}
"""Properties that are not called as their parameter."""


@pytest.mark.parametrize(
    "name", ["patches", "rate", "window", "folds", "seed", "target", "every_activity", "band", "magnetic_dip"]
)
@pytest.mark.usefixtures("blender")
def test_a_property_is_as_declared(name):
    shown = W2W_PG_study.bl_rna.properties[PROPERTIES.get(name, name)]
    parameter = parameters_of(StudyConfig)[name]
    assert shown.name.startswith(parameter.title)
    assert shown.default == pytest.approx(parameter.default)
    assert shown.hard_min == pytest.approx(parameter.least)
    if parameter.most is not None:
        assert shown.hard_max == pytest.approx(parameter.most)


def test_a_unit_stands_in_the_label_where_blender_does_not_show_it():
    assert declared("rate")["name"] == "Rate (Hz)"
    assert declared("window", unit="TIME_ABSOLUTE")["name"] == "Window"


def test_none_is_0_and_what_differs_is_said():
    band = declared("root_band", min=0, precision=1)
    assert (band["default"], band["min"], band["precision"]) == (0, 0, 1)


@pytest.mark.parametrize("given", [1 / 3, 0.85, 1e-5, 60.0])
def test_a_number_that_was_not_touched_is_the_one_that_was_given(given: float) -> None:
    assert as_given(float(np.float32(given)), given) == given


def test_a_number_that_was_typed_is_the_one_that_was_typed() -> None:
    assert as_given(float(np.float32(0.7)), 1 / 3) == 0.7
    assert as_given(float(np.float32(2.125)), float("nan")) == 2.125
    assert as_given(float(np.float32(-64.3)), 66.8) == -64.3
