# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w run --help` says what a study's records declare, the most common options first."""

import re

import pytest

from w2w.core.keypoints.facts import PoseFacts
from w2w.core.parameters import parameters_of
from w2w.core.study.config import StudyConfig
from w2w.headless.app import APP
from w2w.headless.runs.clip_task import Engine
from w2w.headless.study_options import DEFAULTS, NAMES, StudyOptions

typer_testing = pytest.importorskip("typer.testing")


def _help(width: int) -> str:
    return typer_testing.CliRunner().invoke(APP, ["run", "--help"], env={"COLUMNS": str(width)}).output


def test_every_parameter_has_its_option_with_its_help_and_the_common_ones_come_first():
    printed = _help(160)
    common, *others = re.split(r"─ (?=Bodies and files|Signals|Ranking|Design|What|How)", printed)
    for name, parameter in parameters_of(StudyConfig).items():
        if parameter.group is None:
            continue
        option = NAMES.get(name, f"--{name.replace('_', '-')}") + " "
        part = next((part for part in others if part.startswith(parameter.group)), "")
        assert option in (part if parameter.group else common), name
        assert parameter.help.split()[0] in printed
    assert 15 <= len(set(re.findall(r"--(?!no-)[a-z][a-z-]+ ", common))) <= 25
    assert len(others) == 6


def test_help_fits_narrow_consoles():
    assert max(map(len, _help(80).splitlines())) <= 80


def test_how_a_run_is_done_is_as_its_options_say():
    asked = StudyOptions(workers=3, clip_limit=20.0, verify=True, signals=False, pose_rate=30.0)
    pose = PoseFacts(rate=30.0)
    assert asked.engine() == Engine(workers=3, limit_s=20.0, pose=pose, verify=True, signals=False)


def test_without_options_a_study_has_its_declared_defaults():
    assert StudyOptions().config() == StudyConfig()
    assert StudyOptions(workers=1).engine() == Engine()
    assert (DEFAULTS.band, DEFAULTS.only, DEFAULTS.costs, DEFAULTS.root_band) == (10.0, "", None, None)
