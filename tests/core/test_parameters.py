# SPDX-License-Identifier: GPL-3.0-or-later
"""A study's parameters are read back as they were, and a wrong key or value is named with what is allowed."""

import json

import pytest

from w2w.core.imu.presets import preset
from w2w.core.imu.synthesis import Synthesis
from w2w.core.imu.virtual import FurtherSensors
from w2w.core.parameters import parameters_of
from w2w.core.selection.constraints import Constraints
from w2w.core.study.config import StudyConfig
from w2w.core.study.results import StudyResults
from w2w.core.windows.windows import WindowSpec


def test_every_parameter_is_read_back_as_it_was():
    config = StudyConfig(
        placements=(("belt", 12), ("cuff", "left forearm 85% 50%"), ("chest", (0.0, -0.1, 1.25))),
        garments=("tshirt",),
        synthesis=Synthesis(rate_hz=80, cutoff_hz=None, convention="paper"),
        sensor="watch",
        own_sensor=preset("phone"),
        windows=WindowSpec(3.0, 0.7),
        weights=(("walking", 2.0),),
        max_places=3,
        constraints=Constraints(only=("left",), costs=(("head", 3.0),)),
    )
    assert StudyConfig.from_dict(json.loads(json.dumps(config.as_dict()))) == config
    barometer = StudyConfig(further=FurtherSensors(("barometer",), ("barometer",)))
    assert StudyConfig.from_dict(json.loads(json.dumps(barometer.as_dict()))) == barometer


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"fold": 5}, "fold is unknown; there are patches, .*folds"),
        ({"windows": {"lenght_s": 2}}, "windows.lenght_s is unknown; there are length_s, stride_s"),
        ({"windows": {"length_s": "two"}}, "windows.length_s must be a number, not 'two'"),
        ({"windows": {"length_s": 0.05, "stride_s": 0.05}}, "windows.length_s must be from 0.1 to 600"),
        ({"windows": 2}, "windows must hold length_s, .*, not 2"),
        ({"folds": 2.5}, "folds must be a whole number, not 2.5"),
        ({"folds": 1}, "folds must be a whole number from 2 to 1000, not 1"),
        ({"target": 1.5}, "target must be from 0.01 to 1, not 1.5"),
        ({"target": float("nan")}, "target must be from 0.01 to 1, not nan"),
        ({"by_subject": 1}, "by_subject must be true or false, not 1"),
        ({"garments": "tshirt"}, "garments must be a list, not 'tshirt'"),
        ({"weights": [["walking"]]}, r"weights\[0\] must be a list of 2"),
        ({"synthesis": {"convention": "mine"}}, "synthesis.convention must be 'physical' or 'paper'"),
    ],
)
def test_what_cannot_be_is_named_with_what_is_allowed(given, said):
    with pytest.raises(ValueError, match=said):
        StudyConfig.from_dict(given)


def test_a_results_folder_names_its_file(tmp_path):
    with pytest.raises(ValueError, match=r"config\.json: seed must be a whole number, not 'first'"):
        StudyResults(tmp_path, None, (), {"seed": "first"}, None).config()


def test_a_parameter_finds_its_value():
    window = parameters_of(StudyConfig)["window"]
    assert (window.path, window.unit, window.default) == (("windows", "length_s"), "s", 2.0)
    changed = StudyConfig(windows=WindowSpec(4.0))
    assert window.of(changed) == changed.windows.length_s == 4.0
