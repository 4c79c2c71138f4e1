# SPDX-License-Identifier: GPL-3.0-or-later
"""The notebooks of docs/notebooks as they were last run, and progress outside of a notebook."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from w2w.api.notebook import progress_bar, tracked

NOTEBOOKS = sorted((Path(__file__).resolve().parents[2] / "docs" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_cell_ran_and_none_failed(path):
    cells = [cell for cell in json.loads(path.read_text("utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    assert not [output for cell in cells for output in cell["outputs"] if output["output_type"] == "error"]


def test_synthesizing_and_ranking_show_bars_in_a_notebook():
    shown = "".join(path.read_text("utf-8") for path in NOTEBOOKS)
    for label in ("Synthesizing signals", "Ranking patches"):
        assert f"{label} <progress" in shown


def test_a_heatmap_shows_itself_without_a_magic_word():
    text = next(path for path in NOTEBOOKS if path.stem == "five_lines").read_text("utf-8")
    assert "image/png" in text
    assert "%matplotlib" not in text


def test_a_terminal_gets_a_line_that_ends(capsys, monkeypatch):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    show = progress_bar("Ranking")
    for done in (0.5, 0.501, 1.0):
        show(done)
    assert capsys.readouterr().err == "\rRanking: 50 %\rRanking: 100 %\n"


def test_elsewhere_nothing_is_shown(capsys):
    assert list(tracked([3, 4], "Reading")) == [3, 4]
    progress_bar("Ranking")(0.5)
    assert capsys.readouterr() == ("", "")


def test_no_cell_asks_a_shell():
    """A notebook may be started where `w2w` is no command, and what a pipe hides no test sees."""
    for path in NOTEBOOKS:
        cells = [cell for cell in json.loads(path.read_text("utf-8"))["cells"] if cell["cell_type"] == "code"]
        assert not [cell for cell in cells if "".join(cell["source"]).startswith(("!", "%"))]
