# SPDX-License-Identifier: GPL-3.0-or-later
"""The first screen in people's words: what to wear, how good it is, whether a habit would do."""

import io
import re
from html import unescape
from pathlib import Path

import pytest
from rich.console import Console

from w2w.core.findings.advice_content import answer_content
from w2w.core.selection.advice import advise
from w2w.core.selection.scored import ScoredMap
from w2w.core.study.results import StudyResults
from w2w.headless.reports.console_tables import show_answer
from w2w.report.page import report_page

from ..command_line import cli
from ..golden import OPTIONS, _write_library
from ..here import clips_here, ranked_roughly

NOBODY_SAYS = re.compile(
    r"cut[ _]out|in[ _]a[ _]stream|do(es)? as well|dealt into halves|turned as it sat|with \d+ %|patch \d"
    r"|as as|nan\b|None\b|\[\]",
    re.IGNORECASE,
)
"""Words of no designer, and slips."""

TO_WEAR = re.compile(r"\b(Wear|Keep|Start with) (it |a|an|the)\b|\bmay do better than\b")
HOW_GOOD = re.compile(r"\b(about \d of 10|nearly all) moments right\b")


@pytest.fixture(scope="module")
def demo(made_once) -> Path:
    """Results of a run on motions of the demo."""

    def make(folder: Path) -> None:
        _write_library(folder / "library")
        with clips_here(), ranked_roughly():
            code, said = cli("run", folder / "library", "--out", folder / "results", *OPTIONS.split())
        assert code == 0, said

    return made_once("first screen", make) / "results"


@pytest.fixture
def results(request) -> Path:
    folder = request.getfixturevalue(request.param)
    return folder / "out" if request.param == "quick_run" else folder


def console_of(study: StudyResults) -> str:
    """What `w2w run` says first."""
    console = Console(record=True, width=200, file=io.StringIO())
    advice = advise(ScoredMap(study.utility, study.patches, study.body()), None)
    show_answer(advice, study.utility, [], console)
    return console.export_text()


def page_of(study: StudyResults) -> str:
    """What the report shows before the map, without its tags; the web app shows the same."""
    body = report_page(study).partition("<main>")[2].partition('<section class="map"')[0]
    return unescape(re.sub(r"<[^>]*>", " ", body))


def panel_of(study: StudyResults) -> str:
    """The panel's page *Answer*: the sentence of the answer, then its products."""
    advice = advise(ScoredMap(study.utility, study.patches, study.body()), None)
    content = answer_content(advice.answer, study.patches, [])
    return " ".join([content["sentence"], *(product["name"] for product in content["products"])])


@pytest.mark.parametrize("door", [console_of, page_of, panel_of])
@pytest.mark.parametrize("results", ["demo", "drawn_results", "sparse_results", "quick_run"], indirect=True)
def test_a_newcomer_reads_what_to_wear_how_good_it_is_and_whether_a_habit_would_do(door, results):
    said = " ".join(door(StudyResults.load(results)).split())
    assert TO_WEAR.search(said), said
    assert HOW_GOOD.search(said), said
    assert "belt clip" in said
    assert "watch" in said or "all places do alike" in said
    assert not NOBODY_SAYS.search(said), NOBODY_SAYS.search(said)


@pytest.mark.parametrize("door", [console_of, page_of])
def test_one_product_is_recommended_and_others_at_its_place_are_as_good(door, quick_run):
    said = " ".join(door(StudyResults.load(quick_run / "out")).split())
    assert len(re.findall(r"recommended(?! place)", said)) == 1
    assert re.search(r"(?i)\bring\b.{0,60}as good", said)


@pytest.mark.parametrize("door", [console_of, page_of])
@pytest.mark.parametrize("results", ["demo", "drawn_results"], indirect=True)
def test_the_habit_that_the_sentence_names_has_a_line_of_its_own(door, results):
    said = " ".join(door(StudyResults.load(results)).split())
    assert re.search(r"(?i)\b(?<!a )belt clip (│|0?\.\d\d|right|left)", said), said
