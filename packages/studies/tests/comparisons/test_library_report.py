# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of a library's study: its verdict, its learning curve and what is not known."""

import json

import numpy as np
import pytest

from w2w.core.windows.inputs import ArrayBlocks
from w2w_studies.comparisons.library import LibraryFindings
from w2w_studies.comparisons.library_report import verdict, write_library
from w2w_studies.validation.library_repeats import MeansAgree, Repeats
from w2w_studies.validation.within_sources import MixedWindows, rank_within_sources


def again(*rho):
    values = np.array(rho)
    return Repeats(
        values,
        {"jump": values - 0.1, "wave": values},
        values / 5,
        np.full(len(values), 0.6),
        values + 0.05,
        {"film": [MeansAgree(one, one / 2) for one in rho]},
    )


@pytest.fixture(scope="module")
def findings():
    """Two activities by three performers of one source."""
    rows = [(name, who, clip) for name in ("jump", "wave") for who in "abc" for clip in range(3)]
    activity, performer, _ = np.array(rows).T
    motion = np.array([" ".join(map(str, row)) for row in rows])
    features = np.random.default_rng(0).normal(size=(len(rows), 5, 4)).astype(np.float32)
    features[activity == "jump", 0] += 3
    windows = MixedWindows(
        ArrayBlocks(features),
        activity,
        motion,
        np.full(len(rows), "film"),
        performer,
        np.ones(len(rows), bool),
    )
    ranked = rank_within_sources(windows)
    curve = {3: again(0.2, 0.4), 5: again(0.5, np.nan)}
    shown = ("jump", "wave")
    return LibraryFindings(windows, ranked, ranked, again(0.6, 0.8), again(0.9), curve, shown, {}, {}, None)


def test_the_page_its_curve_and_its_values_agree(findings, tmp_path):
    page = write_library(tmp_path, findings)
    assert page == (tmp_path / "library.md").read_text()
    assert "| film | 18 | 3 | 2 |" in page
    assert "| 3 | 0.30 | 0.25 | 0.60 |" in page
    assert "| 5 | 0.50 | 0.45 | 0.60 |" in page
    assert "0.70 (0.60 to 0.80) | 0.14 | 0.65 |" in page
    assert "| all | 0.70 (0.60 to 0.80) | 0.75 (0.65 to 0.85) |" in page
    assert "| less film | 0.70 (0.60 to 0.80) | 0.35 (0.30 to 0.40) |" in page
    assert "No two activities are shown by two sources each." in page
    assert (tmp_path / "library_curve.png").read_bytes().startswith(b"\x89PNG")
    content = json.loads((tmp_path / "library.json").read_text())
    assert content["rho_of_halves_by_halving"] == [0.6, 0.8]
    assert content["rho_of_halves_by_source_means"] == 0.75
    assert content["rho_of_halves_less_a_source"]["film"]["of_sources"] == [0.3, 0.4]
    assert content["source_never_seen"] is None
    assert content["curve"][1] == {"clips": 5, "rho_of_halves": 0.5, "rho_by_activity": 0.45, "f1": 0.6}
    assert content["activities"][0]["rho_between_sources"] is None
    assert (
        (tmp_path / "library.csv").read_text().startswith("activity,sources,clips,performers,f1_best_patch")
    )


@pytest.mark.parametrize(
    ("rho", "words"),
    [
        ((0.9, 0.86), "rho 0.88 (0.86 to 0.90) for the mean: enough clips and performers"),
        ((0.7,), "below 0.85: about 2.4 times as many clips"),
        ((-0.1, 0.1), "these clips do not show a map that repeats"),
        ((np.nan,), "Performers cannot be halved"),
    ],
)
def test_the_verdict_says_whether_clips_are_enough(findings, rho, words):
    found = LibraryFindings(**{**vars(findings), "repeats": again(*rho)})
    assert words in verdict(found)
