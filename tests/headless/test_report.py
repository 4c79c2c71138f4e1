# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's file: whole, small, the same every time, and harmless whatever the labels hold."""

import base64
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from blender_addon.w2w.core.patches import PatchSet
from blender_addon.w2w.core.utility import UtilityMap
from headless.__main__ import APP
from headless.report import write_report
from headless.report_data import as_script_json, packed, title


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
    assert len(page.encode()) < 5_000_000
    reader = Reader(page)
    links = [value for name, value in reader.attributes if name in ("src", "href", "action", "poster")]
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
        ("f1", utility.mean, utility.f1),
        ("low", utility.mean_low, utility.f1_low),
        ("high", utility.mean_high, utility.f1_high),
    ):
        maps = unpack(data[name]).reshape(4, -1) / 65535
        np.testing.assert_allclose(maps, np.vstack([whole, parts.T]), atol=1e-5)
    assert data["names"] == list(patches.names)
    assert [data["regions"][code] for code in unpack(data["region"])] == list(patches.regions)


def test_the_page_colours_vertices_as_the_heatmaps_do(data, drawn_results):
    """The shares it is given, whole again, spread scores to within half a thousandth of F1."""
    patches = PatchSet.load(drawn_results / ".w2w" / "patches.npz")
    share = unpack(data["spread_share"]).astype(float)
    vertex = np.repeat(np.arange(len(patches.labels)), unpack(data["spread_count"]))
    scores = np.random.default_rng(0).random(len(patches))
    total = np.bincount(vertex, share * scores[unpack(data["spread_place"])])
    np.testing.assert_allclose(total / np.bincount(vertex, share), patches.to_vertices(scores), atol=0.0005)


def test_tables_tell_what_the_summary_tells(page, drawn_results):
    summary = json.loads((drawn_results / "summary.json").read_text())
    text = " ".join(" ".join(Reader(page).texts).split())
    assert summary["best_single_patch"]["name"] in text
    assert summary["subset"]["sentence"] in text
    assert summary["protocol"] in text
    for place in summary["subset"]["places"]:
        assert f"{place['name']} {place['mean_f1']:.2f} {place['mean_max_f1_so_far']:.2f}" in text.replace(
            " –", ""
        )
    assert "empty <b>file</b>" in text
    assert "bootstrap intervals over clips" in text


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
