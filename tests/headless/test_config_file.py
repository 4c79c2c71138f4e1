# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's options from a file, and what commands print for programs."""

import inspect
import json
import tomllib

import pytest

from w2w.core.study.config import StudyConfig
from w2w.headless.commands.run import run
from w2w.headless.config_file import NO_OPTIONS, OF_MACHINES, options_in, template
from w2w.headless.study_options import StudyOptions

from ..command_line import cli

pytestmark = pytest.mark.usefixtures("few_orders")

OPTIONS = {name: "Path" in str(one.annotation) for name, one in inspect.signature(run).parameters.items()}


def in_file(tmp_path, text, name="study.toml"):
    (tmp_path / name).write_text(text, encoding="utf-8")
    return options_in(tmp_path / name, OPTIONS)


def test_the_template_has_every_option_and_its_default(tmp_path):
    text = template(run)
    found = in_file(tmp_path, text)
    parameters = inspect.signature(run).parameters
    assert found == {name: parameters[name].default for name in found}
    without = {
        name
        for name, one in parameters.items()
        if one.default in (None, "", inspect.Parameter.empty) or name in OF_MACHINES
    }
    assert {*found} == {*parameters} - without - {*NO_OPTIONS}
    uncommented = "\n".join(
        line.removeprefix("# ") if line.startswith("# ") and line.endswith(' = ""') else line
        for line in text.splitlines()
    )
    assert len(list(tomllib.loads(uncommented))) > 20


def test_the_configuration_of_a_run_gives_its_options_back(tmp_path):
    config = StudyConfig(seed=7, folds=3, by_subject=True, background=("walking", "sitting"), target=0.8)
    text = json.dumps({"parameters": config.as_dict(), "versions": {}})
    found = in_file(tmp_path, text, "config.json")
    assert StudyOptions(**found).config() == config


def test_keys_are_those_of_the_configuration_or_of_the_options(tmp_path):
    text = 'library = "clips"\nout = "/results"\nby-subject = true\nrate = 25\n[windows]\nlength_s = 3.0\n'
    assert in_file(tmp_path, text) == {
        "library": str(tmp_path / "clips"),
        "out": "/results",
        "by_subject": True,
        "rate": 25,
        "window": 3.0,
    }
    assert in_file(tmp_path, 'background = ["walking", "sitting"]') == {"background": "walking,sitting"}


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[windows]\nlenght_s = 3.0", "there is no 'windows.lenght_s'; did you mean windows.length_s"),
        ("[synthesis]\ngravity = [0, 0, 9.8]", "there is no 'synthesis.gravity'"),
        ('placements = [["pod", 12]]', "'placements' is given as the path of a csv"),
        ("rate = ", "study.toml cannot be read as options"),
    ],
)
def test_what_is_no_option_is_said(tmp_path, text, why):
    with pytest.raises(ValueError, match=why):
        in_file(tmp_path, text)


def test_a_run_by_a_file_and_options_that_count_more(door, tmp_path, monkeypatch):
    """Two folds in the file, three on the command line; nothing else is given there."""
    lines = ("patches = 4", "folds = 2", "workers = 1", "pictures = false", "signals = false")
    where = f'library = "{door / "MY_CLIPS"}"\nlabels = "{door / "labels.csv"}"\nout = "results"\n'
    (tmp_path / "study.toml").write_text(where + "\n".join(lines))
    begun = []
    monkeypatch.setattr("w2w.headless.commands.run.execute_bodies", lambda *given: begun.append(given))
    code, output = cli("run", "--config", tmp_path / "study.toml", "--folds", 3)
    assert code == 0, output
    ((plan, _, out, *_),) = begun
    assert (out, len(plan.library.clips)) == (tmp_path / "results", 12)
    assert (plan.config.patches, plan.config.folds) == (4, 3)
    assert (plan.engine.workers, plan.engine.signals, plan.pictures, plan.report) == (1, False, False, True)


def test_init_writes_once(tmp_path):
    assert cli("init", tmp_path / "study.toml")[0] == 0
    code, output = cli("init", tmp_path / "study.toml")
    assert (code, "study.toml" in output) == (2, True)


@pytest.mark.later
def test_json_is_all_that_a_program_reads(door, tmp_path):
    for given in (
        ("sensors",),
        ("sensors", "bmi270"),
        ("inspect", door / "MY_CLIPS" / "waving" / "waving 0.npz"),
        ("place", door / "RESULTS", "--compare", "left toes"),
        ("place", door / "RESULTS"),
        ("export", door / "RESULTS", "--for", "torch", "--places", "left toes", "--out", tmp_path / "torch"),
    ):
        code, output = cli(*given, "--json")
        assert code == 0, output
        assert json.loads(output)
    code, output = cli("place", door / "RESULTS", "--compare", "tail", "--json")
    assert (code, 'is called "tail"' in output.replace("\n", " ")) == (2, True)


@pytest.mark.later
def test_short_help_is_help():
    assert cli("run", "-h") == cli("run", "--help")
