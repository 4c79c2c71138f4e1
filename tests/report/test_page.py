# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's file: whole, small, the same every time, and harmless whatever the labels hold."""

import base64
import io
import json
import re
import shutil
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given, strategies as st
from rich.console import Console
from typer.testing import CliRunner

from w2w.core.patches.own_placements import placement_vertices, read_placements
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.costs import costs_at, is_as_good
from w2w.core.ranking.utility import UtilityMap
from w2w.core.selection.advice import advise
from w2w.core.selection.headline import more_clips
from w2w.core.selection.scored import ScoredMap, best_single
from w2w.core.study.results import StudyResults
from w2w.core.wording import capital
from w2w.headless.app import APP
from w2w.headless.commands.report import write_report
from w2w.headless.reports.console_tables import show_answer
from w2w.report.page import as_script_json, packed, report_page, title


class Reader(HTMLParser):
    """Elements, attributes and the text outside of scripts and styles."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.attributes, self.texts, self.scripts = [], [], [], []
        self.inside = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.elements.append(tag)
        self.attributes += attrs
        self.inside = tag if tag in ("script", "style") else ""

    def handle_endtag(self, tag):  # noqa: ARG002
        self.inside = ""

    def handle_data(self, data):
        (self.scripts if self.inside == "script" else self.texts).append(data)


@pytest.fixture(scope="module")
def page(drawn_results):
    return write_report(drawn_results).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def data(page):
    return json.loads(re.search(r'id="w2w-data">(.*?)</script>', page, re.DOTALL)[1])


def unpack(entry):
    return np.frombuffer(base64.b64decode(entry["data"]), np.dtype(entry["type"]).newbyteorder("<"))


def test_it_is_one_small_file_that_asks_nothing_of_the_network(page):
    assert len(page.encode()) < 1_000_000
    reader = Reader(page)
    links = [value for name, value in reader.attributes if name in ("src", "href", "action", "poster")]
    assert links
    assert all(value.startswith(("#", "data:")) for value in links), links
    assert "default-src 'none'" in dict(reader.attributes)["content"] or "default-src 'none'" in page
    assert not re.search(r"https?://(?!www\.w3\.org)|@import|\bfetch\(|XMLHttpRequest", page)


def test_labels_cannot_break_out(page, data):
    reader = Reader(page)
    assert reader.elements.count("script") == 3  # the data and two scripts of ours
    assert "img" not in reader.elements
    assert not any(name.startswith("on") for name, _ in reader.attributes)
    assert any("alert(1)" in text for text in reader.texts)  # shown as what it is
    assert any("onerror" in text for text in reader.texts)
    assert sum("alert(1)" in text for text in reader.scripts) == 1  # as data
    assert any("<script>alert(1)</script>" in name for name in data["titles"])


@given(st.text())
def test_data_in_a_script_ends_no_script_and_comes_back(text):
    written = as_script_json({"label": text})
    assert not set("<>&\u2028\u2029") & set(written)
    assert json.loads(written) == {"label": text}


@given(st.lists(st.integers(0, 2**32 - 1), max_size=20))
def test_packed_numbers_come_back(numbers):
    entry = packed(np.array(numbers, dtype=np.int64))
    assert unpack(entry).tolist() == numbers
    assert entry["type"] == ("uint8" if max(numbers, default=0) < 256 else entry["type"])


def test_the_view_holds_the_body_and_its_scores(data, drawn_results, bundled_body):
    utility, patches = (
        UtilityMap.load(drawn_results / "utility.npz"),
        PatchSet.load(drawn_results / ".w2w" / "patches.npz"),
    )
    points = unpack(data["positions"]).reshape(-1, 3) * data["step"] + data["corner"]
    assert np.abs(points - bundled_body.vertices).max() < 2e-5
    np.testing.assert_array_equal(unpack(data["faces"]).reshape(-1, 3), bundled_body.faces)
    for name, whole, parts in (
        ("expected", utility.expected_mean, utility.expected_f1),
        ("raw", utility.mean, utility.f1),
        ("low", utility.mean_low, utility.f1_low),
        ("high", utility.mean_high, utility.f1_high),
    ):
        maps = unpack(data[name]).reshape(4, -1) / 65535
        np.testing.assert_allclose(maps, np.vstack([whole, parts.T]), atol=1e-5)
    for name in ("expected_low", "expected_high"):
        np.testing.assert_allclose(unpack(data[name]) / 65535, getattr(utility, name), atol=1e-5)
    base = json.loads((drawn_results / "summary.json").read_text())["answer"]["costs_are_against"]
    np.testing.assert_array_equal(unpack(data["as_good"]), is_as_good(costs_at(utility, base)))
    assert data["names"] == list(patches.names)
    assert [data["regions"][code] for code in unpack(data["region"])] == list(patches.regions)


def test_the_page_colours_vertices_as_the_heatmaps_do(data, drawn_results):
    """The shares it is given, whole again, spread scores to within half a thousandth of F1."""
    patches = PatchSet.load(drawn_results / ".w2w" / "patches.npz")
    share = unpack(data["spread_share"]).astype(float)
    vertex = np.repeat(np.arange(len(patches.labels)), unpack(data["spread_count"]))
    scores = np.random.default_rng(0).random(len(patches))
    total = np.bincount(vertex, share * scores[unpack(data["spread_patch"])])
    np.testing.assert_allclose(total / np.bincount(vertex, share), patches.to_vertices(scores), atol=0.0005)


def test_tables_tell_what_the_summary_tells(page, drawn_results):
    summary = json.loads((drawn_results / "summary.json").read_text())
    text = " ".join(" ".join(Reader(page).texts).split())
    assert summary["best_single_patch"]["name"] in text
    assert summary["protocol"] in text
    assert "empty <b>file</b>" in text
    assert "bootstrap intervals over clips" in text


def read(results):
    text = write_report(results).read_text(encoding="utf-8")
    return text, " ".join(" ".join(Reader(text).texts).split())


def test_what_is_counted_is_what_was_ranked(sparse_results):
    """16 of 17 files became signals; 14 of them show the three activities that could be ranked."""
    summary = json.loads((sparse_results / "summary.json").read_text())
    assert summary["clips"] == {"found": 17, "used": 16, "ranked": 14, "skipped": 1}
    assert summary["ranked_activities"] == ["arm_raise", "jump", "sitting"]
    assert set(summary["left_out"]) == {"bow", "kneel"}
    assert {name for name, entry in summary["activities"].items() if entry["ranked"]} == {
        "arm_raise",
        "jump",
        "sitting",
    }
    _, text = read(sparse_results)
    assert "how well one sensor tells 3 activities apart on other recordings of them" in text
    assert "2 of 5 activities are not ranked: bow, kneel: each has only one clip;" in text
    assert (
        "14 of 17 clips ranked, in 3 activities; 2 clips could be used but belong to 2 activities that could "
        "not be ranked; 1 skipped." in text
    )


def test_what_other_clips_would_give_stands_first(sparse_results):
    worn = json.loads((sparse_results / "summary.json").read_text())["worn_together"]
    _, text = read(sparse_results)
    low, high = worn["expected_f1_interval"]
    assert 0 <= low <= worn["expected_f1"] <= high <= 1
    first = f"{len(worn['places'])} sensors"
    assert (first in text) == (len(worn["places"]) > 1)
    said = json.loads((sparse_results / "summary.json").read_text())["answer"]["sentence"]
    assert text.index(said) < text.index("Activity by activity")
    for place, others in zip(worn["places"], worn["alternatives"], strict=True):
        interval = f"{place['expected_f1_so_far']:.2f} too few clips"  # jump has two
        called, same = capital(place["product"] or place["name"]), " or ".join(others) or "none"
        assert f"{called} {interval} {place['mean_f1_so_far']:.2f} {same}" in text


def test_another_classifier_s_page_says_why_it_has_no_set(sparse_results, tmp_path):
    out = tmp_path / "trees"
    shutil.copytree(sparse_results, out)
    summary = json.loads((out / "summary.json").read_text())
    (out / "summary.json").write_text(json.dumps(summary | {"worn_together": None}))
    assert "Sets to wear together are chosen by the classifier ridge only" in read(out)[1]


def test_intervals_of_too_few_clips_carry_a_caution(sparse_results, drawn_results):
    summary = json.loads((sparse_results / "summary.json").read_text())
    caution = "from 2 clips only: too few for an interval"
    assert summary["activities"]["jump"]["interval_caution"] == caution
    assert summary["activities"]["sitting"]["interval_caution"] == ""
    assert "1 of 3 ranked activities has fewer than 5 clips" in str(summary["cautions"])
    page, text = read(sparse_results)
    assert re.search(rf"Jump [01]\.\d\d .*? [01]\.\d\d [01]\.\d\d {caution} 2 2 8 ", text)
    assert re.search(r"Sitting [01]\.\d\d .*? [01]\.\d\d [01]\.\d\d [01]\.\d\d–[01]\.\d\d 6 6 24 ", text)
    assert "1 of 3 ranked activities has fewer than 5 clips" in text
    view = json.loads(re.search(r'id="w2w-data">(.*?)</script>', page, re.DOTALL)[1])
    assert view["cautions"] == ["from only 2 clips of jump: too few for an interval", "", caution, ""]
    assert "too few for an interval" not in read(drawn_results)[1]


def test_there_is_one_table_of_best_regions(page):
    assert len(re.findall(r"<h3>Best regions", page)) == 1
    rows = re.search(r'<table id="ranked">.*?<tbody>(.*?)</tbody>', page, re.DOTALL)[1].count("<tr>")
    assert rows == 10  # without a script, too


def test_the_headline_is_that_of_the_summary(page, drawn_results):
    summary = json.loads((drawn_results / "summary.json").read_text())
    utility = UtilityMap.load(drawn_results / "utility.npz")
    text = " ".join(" ".join(Reader(page).texts).split())
    assert text.index(summary["answer"]["sentence"]) < text.index("Worn together")
    assert summary["map_sentence"] in text
    assert summary["map_reliability"] == pytest.approx(utility.reliability, abs=1e-6)
    assert summary["more_clips_per_activity"] == more_clips(utility)


def test_the_console_begins_with_the_answer_and_its_figures(drawn_results):
    utility, out = UtilityMap.load(drawn_results / "utility.npz"), drawn_results
    study, console = StudyResults.load(out), Console(record=True, width=200, file=io.StringIO())
    advice = advise(ScoredMap(utility, study.patches, study.body()), None)
    show_answer(advice, utility, [], console)
    said = " ".join(console.export_text().split())
    assert said.startswith(f"{advice.answer.sentence()} {advice.answer.detail()}")


@pytest.mark.parametrize(
    "crafted",
    [{"cards": 5}, {"cards": [{"patch": 0, "needs": "x"}]}, {"answer": []}, {"worn_together": {"places": 1}}],
)
def test_a_summary_that_no_run_wrote_is_refused_in_a_sentence(drawn_results, tmp_path, crafted):
    out = shutil.copytree(drawn_results, tmp_path / "out")
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    (out / "summary.json").write_text(json.dumps(summary | crafted))
    with pytest.raises(ValueError, match="not as a run writes it"):
        report_page(StudyResults.load(out))


def test_regions_are_sorted_by_the_expected_f1_and_lead_with_it(page, drawn_results):
    utility = UtilityMap.load(drawn_results / "utility.npz")
    summary = json.loads((drawn_results / "summary.json").read_text())
    scores = [entry["best_expected_f1"] for entry in summary["regions"].values()]
    assert scores == sorted(scores, reverse=True)
    first = next(iter(summary["regions"].values()))
    best = summary["best_single_patch"]["patch"]
    assert first["best_patch"] == best == best_single(utility)
    costs = costs_at(utility, summary["answer"]["costs_are_against"])
    assert sum(entry["as_good"] for entry in summary["regions"].values()) == is_as_good(costs).sum()
    rows = re.search(r'<table id="ranked">.*?<tbody>(.*?)</tbody>', page, re.DOTALL)[1].split("</tr>")
    shown = [int(re.search(r'data-patch="(\d+)"', row)[1]) for row in rows if "<td" in row]
    assert shown == [entry["best_patch"] for entry in summary["regions"].values()][:10]
    words = " ".join(re.sub(r"<.*?>", " ", rows[0]).split())
    low, high = utility.expected_low[best], utility.expected_high[best]
    raw = f"{utility.mean[best]:.2f} {utility.mean_low[best]:.2f}–{utility.mean_high[best]:.2f}"
    assert words.endswith(f"{utility.expected_mean[best]:.2f} {low:.2f}–{high:.2f} {raw}")


def test_the_project_s_name_stands_on_the_page(sparse_results, page):
    written, _ = read(sparse_results)
    assert '<p class="kind">Smart &lt;b&gt;shirt&lt;/b&gt; · where to wear</p>' in written
    assert "<title>Smart &lt;b&gt;shirt&lt;/b&gt; – where to wear" in written
    assert '<p class="kind">Where to wear</p>' in page
    again = CliRunner().invoke(APP, ["report", str(sparse_results), "--title", "Glove & <i>sock</i>"])
    assert again.exit_code == 0, again.output
    renamed = (sparse_results / "report.html").read_text("utf-8")
    assert "Glove &amp; &lt;i&gt;sock&lt;/i&gt; · where" in renamed


def test_the_same_results_give_the_same_page(page, drawn_results):
    assert write_report(drawn_results).read_text(encoding="utf-8") == page


def test_the_command_writes_it_again_and_refuses_other_folders(drawn_results, tmp_path):
    (drawn_results / "report.html").unlink()
    done = CliRunner().invoke(APP, ["report", str(drawn_results)])
    assert done.exit_code == 0, done.output
    assert (drawn_results / "report.html").is_file()
    refused = CliRunner().invoke(APP, ["report", str(tmp_path)])
    assert refused.exit_code == 2
    assert "not the results folder of a finished run" in " ".join(refused.output.split())


def test_titles_are_written_as_people_write():
    assert [title(name) for name in ("arm_raise_band", "T-pose", "")] == ["Arm raise band", "T-pose", ""]


def test_cards_say_where_sensors_go_and_their_table_gives_the_same_vertices(drawn_results, page):
    summary = json.loads((drawn_results / "summary.json").read_text())
    study = StudyResults.load(drawn_results)
    text = " ".join(" ".join(Reader(page).texts).split())
    recommended = [place["patch"] for place in summary["worn_together"]["places"]]
    assert [card["patch"] for card in summary["cards"]][-len(recommended) :] == recommended
    for card in summary["cards"]:
        assert card["in_words"] in text
        assert card["in_words"].startswith(capital(card["words"]))
    vertices = placement_vertices(study.body(), read_placements(drawn_results / "placements.csv"))
    there = [int(study.patches.vertices[card["patch"]]) for card in summary["cards"]]
    assert list(vertices.values()) == there
