# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of the studies are there with the studies; without them a sentence says how to get them."""

from importlib.metadata import EntryPoints, entry_points

import pytest
import typer.testing
from typer.testing import CliRunner

from w2w.headless import app
from w2w.headless.app import APP

STUDIES = ("tables", "sweep", "challenge", "demo-library", "study", "validate")
SAID = "W2W's studies are a package of their own"


def w2w(*words):
    done = CliRunner().invoke(APP, words, prog_name="w2w")
    return done.exit_code, done.output


@pytest.mark.parametrize("command", STUDIES)
def test_with_the_studies_each_command_has_its_help(command):
    code, said = w2w(command, "--help")
    assert code == 0
    assert f"Usage: w2w {command}" in said


@pytest.mark.parametrize("words", [(), ("--help",), ("mhad", "--out", "OUT", "-x")], ids=str)
@pytest.mark.parametrize("command", STUDIES)
def test_without_them_it_says_how_to_get_them(monkeypatch, command, words):
    others = EntryPoints(point for point in entry_points(group=app.GROUP) if point.name not in STUDIES)
    monkeypatch.setattr(app, "entry_points", lambda **_: others)
    monkeypatch.setattr(typer.testing, "_get_command", typer.main.get_command)  # conftest keeps one
    code, said = w2w(command, *words)
    assert code == 2
    assert SAID in said
    assert "pip install '.[blender]' ./packages/studies" in said
    assert f"No such command '{command}'" in said


def test_a_typing_error_is_no_study():
    code, said = w2w("serv")
    assert code == 2
    assert SAID not in said
    assert "Did you mean 'serve'" in said
