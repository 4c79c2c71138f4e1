# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of the studies are there with the studies; without them a sentence says how to get them."""

from importlib.metadata import EntryPoints

import pytest
import typer
from typer.testing import CliRunner

from w2w.headless import app as command_line


def app():
    made = typer.Typer(no_args_is_help=True)
    made.command()(lambda: None)
    command_line.add_further_commands(made)
    return made


def w2w(*words):
    done = CliRunner().invoke(app(), words, prog_name="w2w")
    return done.exit_code, done.output


@pytest.mark.parametrize("command", command_line.STUDIES)
def test_with_the_studies_each_command_has_its_help(command):
    code, said = w2w(command, "--help")
    assert code == 0
    assert f"Usage: w2w {command}" in said


@pytest.mark.parametrize("words", [(), ("--help",), ("mhad", "--out", "OUT", "-x")], ids=str)
@pytest.mark.parametrize("command", command_line.STUDIES)
def test_without_them_each_says_how_to_get_it(monkeypatch, command, words):
    monkeypatch.setattr(command_line, "entry_points", lambda **_: EntryPoints())
    code, said = w2w(command, *words)
    assert code == 1
    assert said.startswith(f"w2w {command} is one of W2W's studies")
    assert "pip install '.[blender]'" in said
