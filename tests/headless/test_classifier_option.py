# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w run --classifier`: refused in a sentence before any clip is read."""

import sys

import pytest
import typer
from typer.testing import CliRunner

from w2w.headless.commands.run import run

pytestmark = pytest.mark.usefixtures("made_once_here")


@pytest.fixture
def command(tmp_path):
    app = typer.Typer()
    app.command()(run)
    base = [str(tmp_path / "no library"), "--out", str(tmp_path / "out")]
    return lambda *options: CliRunner().invoke(app, [*base, *options])


def test_an_unknown_classifier_is_named_and_so_are_those_that_exist(command, tmp_path):
    result = command("--classifier", "oracle")
    assert result.exit_code == 2
    assert "no classifier is called 'oracle' here; there are ridge, multi3net, trees" in " ".join(
        result.output.split()
    )
    assert not (tmp_path / "out").exists()


def test_multi3net_without_torch_says_how_to_get_it(command, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    result = command("--classifier", "multi3net")
    assert result.exit_code == 2
    assert "pip install torch==2.13.0" in " ".join(result.output.split())
    assert not (tmp_path / "out").exists()
