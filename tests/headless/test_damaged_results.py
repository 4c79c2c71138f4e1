# SPDX-License-Identifier: GPL-3.0-or-later
"""A results folder with a damaged file in it: every command that reads it says so and ends with its code."""

from __future__ import annotations

import json
import shutil

import pytest
from typer.testing import CliRunner

from w2w.headless.app import APP

pytestmark = pytest.mark.usefixtures("made_once_here")

COMMANDS = {
    "report": [],
    "tables": [],
    "place": ["--max", "2"],
    "need": [],
    "sweep": ["--out", "sweep"],
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("file", ["utility.npz", ".w2w/patches.npz", "summary.json"])
def test_a_file_cut_in_half_is_a_sentence(drawn_results, tmp_path, monkeypatch, command, file):
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "out"
    shutil.copytree(drawn_results, out)
    content = (out / file).read_bytes()
    (out / file).write_bytes(content[: len(content) // 2])
    result = CliRunner().invoke(APP, [command, str(out), *COMMANDS[command]], env={"COLUMNS": "400"})
    assert result.exit_code in (1, 2), result.output
    assert isinstance(result.exception, SystemExit), result.exception
    assert "cannot be read as a results folder" in " ".join(result.output.split())


CRAFTED = {
    "no answer": {"answer": None},
    "places of no list": {"worn_together": {"places": 5}},
    "a set of no kind": {"worn_together": 10**9},
    "a patch by words": {"best_single_patch": {"patch": "x", "name": "y"}},
    "a patch beyond": {"best_single_patch": {"patch": 10**400, "name": "y"}},
    "cards without a sensor": {"cards": [{"patch": 0}]},
    "a sensor of no name": {"cards": [{"patch": 0, "sensor": []}]},
    "garments of no kind": {"garments": {"shirt": 1}},
}


@pytest.mark.parametrize("crafted", CRAFTED)
@pytest.mark.parametrize("command", [*COMMANDS, "export"])
def test_a_summary_that_no_run_wrote_is_a_sentence(drawn_results, tmp_path, monkeypatch, command, crafted):
    monkeypatch.chdir(tmp_path)
    out = shutil.copytree(drawn_results, tmp_path / "out")
    summary = json.loads((out / "summary.json").read_text("utf-8"))
    (out / "summary.json").write_text(json.dumps(summary | CRAFTED[crafted]))
    options = COMMANDS.get(command, ["--for", "aeon", "--out", "exported"])
    result = CliRunner().invoke(APP, [command, str(out), *options], env={"COLUMNS": "400"})
    assert result.exit_code in (1, 2), result.output
    assert isinstance(result.exception, SystemExit), result.exception
    assert "its summary.json is not as a run writes it" in " ".join(result.output.split())
