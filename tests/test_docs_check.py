# SPDX-License-Identifier: GPL-3.0-or-later
"""Stale numbers in documents are found, and those that the documents carry are up to date."""

import importlib.util
import sys
from pathlib import Path

import pytest

TOOL = Path(__file__).resolve().parents[1] / "tools" / "docs_check.py"


@pytest.fixture(scope="module")
def tool():
    spec = importlib.util.spec_from_file_location("docs_check", TOOL)
    module = importlib.util.module_from_spec(spec)
    sys.modules["docs_check"] = module  # dataclasses look there
    spec.loader.exec_module(module)
    return module


def document(folder, text):
    path = folder / "page.md"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_number_that_is_right_passes_and_a_stale_one_is_named(tool, tmp_path, capsys):
    right = "# A\n\n<!-- check: echo 'two  and two'; echo is 4 -->\nThey say two\nand two is\n4.\n\n# B\n"
    assert tool.main([str(document(tmp_path, right))]) == 0
    assert "1 checked, 0 stale" in capsys.readouterr().out
    assert tool.main([str(document(tmp_path, right.replace("4.", "5.")))]) == 1
    told = capsys.readouterr().out
    assert "page.md:3: stale: echo 'two and two'; echo is 4" in told
    assert "what the passage does not say: is 4" in told


def test_a_passage_ends_at_the_next_heading_or_check(tool, tmp_path):
    for end in ("## Next\n", "<!-- check: echo x -->\nx "):
        page = document(tmp_path, f"<!-- check: echo 7 -->\nsix\n{end}7\n")
        first = next(iter(tool.checks_in(page)))
        assert tool.problems_of(first) == ["the command prints what the passage does not say: 7"]


@pytest.mark.parametrize(
    ("command", "problem"),
    [
        ("false", "the command failed (1)"),
        ("false | cat", "the command failed (1)"),
        ("echo oh no >&2; exit 3", "the command failed (3): oh no"),
        ("true", "printed nothing"),
    ],
)
def test_a_command_that_tells_nothing_is_a_problem(tool, tmp_path, command, problem):
    page = document(tmp_path, f"<!-- check: {command} -->\n")
    assert problem in tool.problems_of(next(iter(tool.checks_in(page))))[0]


def test_slow_commands_are_named_and_not_run(tool, tmp_path, capsys):
    page = document(tmp_path, "<!-- check-slow: touch /nowhere/at/all -->\n")
    assert tool.main([str(page)]) == 0
    assert "slow, not run: touch" in capsys.readouterr().out
    assert tool.main([str(page), "--slow"]) == 1


def test_a_command_that_takes_long_is_ended(tool, tmp_path):
    page = document(tmp_path, "<!-- check: sleep 30 -->\n")
    assert "mark it check-slow" in tool.problems_of(next(iter(tool.checks_in(page))), 0.2)[0]


def test_the_documents_carry_commands(tool):
    carried = {check.document.name for path in tool.documents() for check in tool.checks_in(path)}
    assert {"sensors.md", "studies.md", "utility.md"} <= carried


@pytest.mark.slow
def test_the_documents_are_up_to_date(tool):
    found = {
        f"{path.name}:{check.line}": problems
        for path in tool.documents()
        for check in tool.checks_in(path)
        if not check.slow and (problems := tool.problems_of(check))
    }
    assert not found
