# SPDX-License-Identifier: GPL-3.0-or-later
"""What speaks against the answer of a run: which cautions, how heavy, and in the same words at every door."""

import io
from dataclasses import replace
from html import unescape

from rich.console import Console

import w2w
from w2w.core.findings.advice_content import advice_content
from w2w.core.findings.cautions import KNOW, STOPS, WEAKENS, Caution, below, cautions, head
from w2w.core.reading.clips import ITS_OWN
from w2w.core.selection.advice import advise
from w2w.core.selection.scored import ScoredMap
from w2w.core.study.clip_files import is_used
from w2w.core.study.results import StudyResults
from w2w.headless.reports.console_tables import show_answer, show_cautions
from w2w.report.page import report_page


def test_every_door_says_the_same_words(sparse_results):
    study = StudyResults.load(sparse_results)
    said = [Caution(**each).sentence() for each in study.summary["cautions"]]
    assert len(said) >= 2
    details = [entry for entry in study.entries if is_used(entry)]
    ranking = w2w.Ranking(
        study.utility,
        study.patches,
        study.body(),
        None,
        None,
        study.config(),
        clips=study.clips,
        details=details,
    )
    assert [caution.sentence() for caution in ranking.cautions] == said
    console = Console(record=True, width=1000, file=io.StringIO())
    show_cautions(ranking.cautions, console)
    assert console.export_text().splitlines() == said
    page, shown = (
        unescape(text).replace(":</b>", ":") for text in (report_page(study), ranking._repr_html_())
    )
    for sentence in said:
        assert page.count(sentence) == shown.count(sentence) == 1, sentence


def test_what_stops_an_answer_stands_in_its_place_at_every_door(drawn_results):
    stop, weak = Caution(STOPS, "nodding is all at 24 frames a second"), Caution(WEAKENS, "few clips")
    assert head("Wear a ring.", [weak]) == "Wear a ring."
    stopped = "No answer yet: nodding is all at 24 frames a second."
    assert head("Wear a ring.", [weak, stop]) == stopped
    study, console = StudyResults.load(drawn_results), Console(record=True, width=1000, file=io.StringIO())
    advice = advise(ScoredMap(study.utility, study.patches, study.body()), None)
    content = advice_content(advice, study.utility, study.patches, [stop])
    assert content["answer"]["sentence"] == stopped
    assert content["answer"]["patch"] == advice.answer.patch
    assert content["answer"]["recommended"] == ""
    show_answer(advice, study.utility, [stop, weak], console)
    said = console.export_text().strip()
    assert said.startswith(stopped)
    assert said.count(stop.text) == said.count("Weakens the answer: few clips.") == 1
    assert "recommended" not in said
    assert below([weak, stop, stop]) == [weak, stop]
    vars(study)["summary"] = study.summary | content | {"cautions": [stop._asdict(), weak._asdict()]}
    page = report_page(study).partition("</head>")[2]
    assert page.count(stop.text) == 1
    assert "recommended</span>" not in page


def test_a_map_that_repeats_below_a_half_is_cautioned_of(drawn_results):
    study = StudyResults.load(drawn_results)
    clips, facts = study.clips, [entry for entry in study.entries if is_used(entry)]
    for reliability in (0.5, 0.49):
        utility = replace(study.utility, reliability=reliability, beats_average=0.95)
        found = cautions(utility, clips, facts, study.config())
        said = [caution.sentence() for caution in found if "repeats on other clips" in caution.text]
        assert len(said) == (reliability < 0.5)
    assert said[0].startswith("Weakens the answer: map reliability is .49")


def test_the_heaviest_caution_comes_first_and_what_a_few_clips_had_is_named(drawn_results):
    study = StudyResults.load(drawn_results)
    clips, facts = study.clips, [dict(entry) for entry in study.entries if is_used(entry)]
    facts[0] |= {"cut": "frame 0 cut off: a rest pose", "at_full_scale": 0.2, "up_guessed": "y"}
    facts[1] |= {"rest_guessed": "from 8 clips of it"}
    facts[2] |= {"rest_guessed": ITS_OWN}
    long = replace(study.config(), windows=replace(study.config().windows, length_s=60.0))
    found = cautions(study.utility, clips, facts, long, "Of 9 patches 3 on a shirt")
    weights = [caution.weight for caution in found]
    assert weights == sorted(weights, key=[STOPS, WEAKENS, KNOW].index)
    assert weights[0] == STOPS
    assert "60 s" in found[0].text
    name = clips[0].name
    for text in (
        f"{name} (frame 0 cut off",
        f"the most: {name}, 20 %",
        "y is taken as up in 1 clip",
        "the rest pose of 2 clips is a guess, one for each skeleton, but for 1 by the clip's own motion",
        "shirt",
    ):
        assert sum(text in caution.text for caution in found) == 1, text
