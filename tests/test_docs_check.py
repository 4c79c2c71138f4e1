# SPDX-License-Identifier: GPL-3.0-or-later
"""Stale numbers in documents are found, and those that the documents carry are up to date."""

import importlib.util
import re
import sys
from pathlib import Path

import pytest

MOST_WORDS = 22_000
"""Words in all documents together."""

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


def test_a_command_that_takes_long_is_ended(tool, tmp_path, monkeypatch):
    monkeypatch.setattr(tool, "LIMIT_S", 0.2)
    page = document(tmp_path, "<!-- check: sleep 30 -->\n")
    assert "took more than 0.2 s" in tool.problems_of(next(iter(tool.checks_in(page))))[0]


@pytest.fixture
def kept(tool, tmp_path, monkeypatch):
    """A folder for figures' commands, with a count of how often they ran, and a product at a commit."""
    folder = tmp_path / "kept"
    monkeypatch.setattr(tool, "KEPT", folder)
    monkeypatch.setattr(tool, "DATA", tmp_path)
    monkeypatch.setattr(tool, "commit_of_product", lambda: "abcdef01")
    return folder


FIGURES = "# A\n\n<!-- figures: echo '| {} |' | tee -a ran -->\n\n## B\n\nText.\n"


def test_figures_are_written_once_for_a_commit(tool, tmp_path, kept, capsys):
    page = document(tmp_path, FIGURES.format(7))
    assert tool.main([str(page), "--write"]) == 0
    assert tool.main([str(page), "--write"]) == 0
    assert (kept / "ran").read_text() == "| 7 |\n"
    written = page.read_text()
    stamp = r"\*Measured on \d{4}-\d\d-\d\d at abcdef01\.\*"
    assert re.search(rf"-->\n\n\|7\|\n\n{stamp}\n\n## B\n\nText\.\n$", written)
    assert "1 written, 0 stale" in capsys.readouterr().out
    assert tool.main([str(page)]) == 0


@pytest.mark.usefixtures("kept")
def test_figures_of_an_earlier_commit_are_measured_again(tool, tmp_path, monkeypatch):
    page = document(tmp_path, FIGURES.format(7))
    tool.main([str(page), "--write"])
    monkeypatch.setattr(tool, "commit_of_product", lambda: "12345678")
    page.write_text(page.read_text().replace("echo '| 7 |'", "echo '| 8 |'"))
    assert tool.main([str(page)]) == 1
    assert tool.main([str(page), "--write"]) == 0
    assert "\n\n|8|\n\n*Measured" in page.read_text()
    assert page.read_text().count("Measured") == 1


@pytest.mark.usefixtures("kept")
def test_what_was_not_measured_is_stale_until_it_is(tool, tmp_path):
    page = document(tmp_path, FIGURES.format(7).replace("-->", "-->\n\n*Not measured at this version.*"))
    assert tool.main([str(page)]) == 1
    assert tool.main([str(page), "--write"]) == 0
    assert "Not measured" not in page.read_text()
    assert tool.main([str(page)]) == 0


@pytest.mark.usefixtures("kept")
@pytest.mark.parametrize("typed", ["|7|\n| 9 |", "| 9 |"])
def test_a_figure_that_was_typed_in_is_stale(tool, tmp_path, typed, capsys):
    page = document(tmp_path, FIGURES.format(7))
    tool.main([str(page), "--write"])
    page.write_text(page.read_text().replace("\n|7|\n", f"\n{typed}\n"))
    assert tool.main([str(page)]) == 1
    assert "what the command does not print: |9|" in capsys.readouterr().out


@pytest.mark.usefixtures("kept")
def test_a_measurement_that_fails_leaves_the_page(tool, tmp_path, capsys):
    page = document(tmp_path, "<!-- figures: echo no >&2; false -->\n")
    assert tool.main([str(page), "--write"]) == 1
    assert "failed (1): no" in capsys.readouterr().out
    assert page.read_text() == "<!-- figures: echo no >&2; false -->\n"


@pytest.mark.usefixtures("kept")
def test_long_measurements_may_be_left_out_and_need_their_data(tool, tmp_path, monkeypatch, capsys):
    page = document(tmp_path, FIGURES.format(7))
    assert tool.main([str(page), "--quick"]) == 0
    monkeypatch.setattr(tool, "DATA", tmp_path / "none")
    assert tool.main([str(page)]) == 0
    assert capsys.readouterr().out.count("not run: ") == 2


def test_the_documents_are_short(tool):
    """So that what one looks for is found: a new passage takes the place of an older one."""
    words = {path: len(path.read_text(encoding="utf-8").split()) for path in tool.documents()[1:]}
    assert sum(words.values()) <= MOST_WORDS, {path.name: count for path, count in words.items()}


def test_every_block_of_code_begins_and_ends_a_line(tool):
    for path in tool.documents():
        fences = [line for line in path.read_text(encoding="utf-8").splitlines() if "```" in line]
        assert all(re.fullmatch(r" *```[\w-]*( .*)?", line) for line in fences), path.name
        assert len(fences) % 2 == 0, path.name


@pytest.mark.parametrize(
    "typed",
    ["motion files", "how many clips", "which axis is up", "--forbid head", "how sure", "own character",
     "resume", "f1", "license", "licence", "windows"],
)  # fmt: skip
def test_a_newcomer_finds_it_by_these_words_in_a_heading_or_a_question(tool, typed):
    """The site's search shows headings first; bold questions and rows of tables are read at a glance."""
    shown = re.compile(r"^(#.*|\*\*.*|\|.*|[^|]*w2w [^|]*)$", re.M)
    pages = [path.read_text(encoding="utf-8").lower() for path in tool.documents()[1:]]
    assert any(typed in line for page in pages for line in shown.findall(page))


def test_the_documents_carry_commands(tool):
    carried = {check.document.name for path in tool.documents() for check in tool.checks_in(path)}
    assert {"sensors.md", "studies.md", "utility.md"} <= carried


@pytest.mark.slow
def test_the_documents_are_up_to_date(tool):
    found = {
        f"{path.name}:{check.line}": problems
        for path in tool.documents()
        for check in tool.checks_in(path)
        if not check.measured and (problems := tool.problems_of(check))
    }
    assert not found
