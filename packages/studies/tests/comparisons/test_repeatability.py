# SPDX-License-Identifier: GPL-3.0-or-later
"""Halves of the clips choose patches that the other halves find good, unless there is nothing to find."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.command_line import cli
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import WindowLabels
from w2w.core.study.results import StudyResults
from w2w.core.windows.inputs import ArrayBlocks
from w2w_studies.comparisons.repeatability import FIGURES, _drawn, choices

ACTIVITIES, CLIPS, WINDOWS, PATCHES = 3, 8, 3, 12


@pytest.fixture(scope="module")
def labels():
    """Eight people do every activity once, in three windows each."""
    code, who = (part.ravel().repeat(WINDOWS) for part in np.mgrid[:ACTIVITIES, :CLIPS])
    clip = np.char.add(np.char.add(code.astype(str), "/"), who.astype(str))
    return WindowLabels(code.astype(str), clip, who.astype(str), np.ones(len(code), bool))


@pytest.fixture(scope="module")
def windows(labels):
    """Features that tell activities apart the better the higher the patch's number."""
    rng = np.random.default_rng(0)
    features = rng.normal(size=(len(labels.activity), PATCHES, 5)).astype(np.float32)
    for column in range(ACTIVITIES):
        features[labels.activity == str(column), :, column] += 0.25 * np.arange(PATCHES)
    return ArrayBlocks(features)


def means(windows, labels, by_subject):
    return dict(
        zip(FIGURES, choices(windows, labels, StudyConfig(), None, 3, by_subject).mean(axis=0), strict=True)
    )


@pytest.mark.parametrize("by_subject", [False, True])
def test_good_patches_are_chosen_and_deliver(windows, labels, by_subject):
    found = means(windows, labels, by_subject)
    assert found["gain"] > 0.15
    assert found["did"] == 1
    assert found["rho"] > 0.8
    assert found["expected"] == pytest.approx(found["delivered"], abs=0.1)


def test_labels_dealt_by_chance_gain_nothing(windows, labels):
    clips, code = np.unique(labels.motion, return_inverse=True)
    dealt = np.random.default_rng(1).permutation(np.repeat(np.arange(ACTIVITIES), len(clips) // ACTIVITIES))
    shuffled = WindowLabels(dealt[code].astype(str), labels.motion, labels.subject, labels.is_test)
    assert abs(means(windows, shuffled, False)["gain"]) < 0.1


def test_clips_too_few_to_halve_are_refused(windows, labels):
    few = labels.some(np.flatnonzero(np.isin(labels.subject, ["0", "1", "2"])))
    for by_subject in (False, True):
        with pytest.raises(ValueError, match="two activities of 4 motions"):
            choices(windows, few, StudyConfig(), None, 1, by_subject)


def test_a_finished_run_is_halved(drawn_results, monkeypatch):
    """And what people wear anyway is judged on the same halves, if all patches are there."""
    words = ("study", "repeatability", drawn_results, "--halvings", 1, "--patches", 8)
    assert cli(*words)[0] == 2  # the signals and features of this run were never written
    study = StudyResults.load(drawn_results)
    windows = [SimpleNamespace(is_test=np.ones(WINDOWS, bool)) for _ in study.clips]
    labels = WindowLabels.of(study.clips, windows)
    features = np.random.default_rng(0).normal(size=(len(labels.activity), len(study.patches), 16))
    monkeypatch.setattr(StudyResults, "labels", lambda _: labels)
    monkeypatch.setattr(StudyResults, "inputs", lambda *_: ArrayBlocks(features.astype(np.float32)))
    code, said = cli(*words)
    assert code == 0
    assert "2 choices among 8 patches by ridge" in said
    assert said.count("|") == 3 * (
        len(FIGURES[: FIGURES.index("as well")]) + 1
    )  # no product is near 8 patches
    cells = [cell.strip() for cell in cli(*words[:-2])[1].split("|") if cell.strip()]
    found = dict(zip(cells[1 : 1 + len(FIGURES)], map(float, cells[-len(FIGURES) :]), strict=True))
    known = ("recommended", "belt clip", "watch", "energy", "random")
    assert 0 < found["most"] >= max(found[name] for name in known)
    assert 0 <= found["worse"] <= 1
    said = cli(*words[:-2], "--drawn")[1]
    assert "2 choices among" in said
    assert "worse" in said
    assert "knowing" not in said


def test_libraries_are_drawn_of_some_activities_and_motions(labels):
    sizes = set()
    for seed in range(20):
        part = _drawn(labels, np.random.default_rng(seed))
        assert set(labels.activity[part]) == {"0", "1", "2"}  # three at least
        sizes.add(int(part.sum()))
        for motion in set(labels.motion[part]):
            assert part[labels.motion == motion].all()  # whole motions
    assert sizes == {ACTIVITIES * CLIPS * WINDOWS}  # eight of each at least, as there are


def test_choices_on_drawn_libraries_deliver(windows, labels):
    found = choices(windows, labels, StudyConfig(), None, 3, False, drawn=True)
    assert len(found) == 6
    assert found[:, FIGURES.index("gain")].mean() > 0.15
