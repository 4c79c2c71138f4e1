# SPDX-License-Identifier: GPL-3.0-or-later
"""Two classifiers are compared on the same places, clips and folds of a run."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import classifier_agreement
from w2w.core.ranking.halves import Protocol
from w2w.core.ranking.utility import utility_map
from w2w.core.study.ranking import LabelledClip, WindowLabels
from w2w.core.windows.inputs import ArrayBlocks

COUNTS = {"walk": 6, "wave": 5, "bow": 2}
WINDOWS, PLACES = 3, 6


@pytest.fixture
def study():
    """What a run leaves, of places that tell activities apart the better the higher their number."""
    clips = [
        LabelledClip(f"{name} {number}", name, "", f"{name} {number}")
        for name, count in COUNTS.items()
        for number in range(count)
    ]
    windows = [SimpleNamespace(is_test=np.ones(WINDOWS, bool)) for _ in clips]
    labels = WindowLabels.of(clips, windows)
    features = np.random.default_rng(0).normal(size=(len(labels.activity), PLACES, 5)).astype(np.float32)
    for column, name in enumerate(COUNTS):
        features[labels.activity == name, :, column] += 0.4 * np.arange(PLACES)
    protocol = Protocol(labels.activity, labels.motion, None, labels.is_test, sorted(COUNTS), 3, 4)
    return SimpleNamespace(
        clips=clips,
        parameters={"by_subject": False, "folds": 3, "seed": 4},
        utility=utility_map(features, protocol),
        labels=lambda: labels,
        inputs=lambda _: ArrayBlocks(features),
        features=features,
    )


def test_the_runs_own_classifier_agrees_wholly_with_the_run(study):
    again = classifier_agreement.rank_again(study, "ridge", range(PLACES), None)
    np.testing.assert_array_equal(again.f1, study.utility.f1)
    rho, first, second = classifier_agreement.compare(study.utility, again, range(PLACES))["mean"]
    assert rho.rho == pytest.approx(1)
    assert first == second


def test_activities_of_few_clips_stay_out_with_their_windows(study):
    again = classifier_agreement.rank_again(study, "ridge", [5, 0], None, least=5)
    assert again.activities == ("walk", "wave")
    assert set(again.clip.tolist()) == {clip.name for clip in study.clips if clip.activity != "bow"}
    assert again.f1[0].mean() > again.f1[1].mean()  # in the order asked for
    with pytest.raises(ValueError, match="not of the same clips"):
        classifier_agreement.compare(study.utility, again, [5, 0])


def test_places_are_served_as_asked_from_memory_or_disk(study):
    some = classifier_agreement.SomePlaces(ArrayBlocks(study.features), [3, 4, 1])
    wanted = study.features[:, [3, 4, 1]]
    for one in (some, classifier_agreement.in_memory(some)):
        assert one.shape == wanted.shape
        np.testing.assert_array_equal(one.patches(0, 2), wanted[:, :2])
        np.testing.assert_array_equal(one.patches(1, 3), wanted[:, 1:])


class NamesAll:
    """Names every window that it is asked for as the first activity."""

    def predict_folds(self, windows, _labels, _fold, is_test, _progress):
        return np.zeros((is_test.sum(), windows.shape[1]), np.int16)


def test_only_the_folds_asked_for_are_compared(study):
    some = classifier_agreement.SomeFolds(NamesAll(), (0, 2))
    again = classifier_agreement.rank_again(study, some, range(PLACES), None)
    assert 0 < some.tested.sum() < len(again.truth)
    assert not (set(again.clip[some.tested]) & set(again.clip[~some.tested]))
    again = replace(again, predictions=np.where(some.tested[:, None], study.utility.predictions, -1))
    rho, first, second = classifier_agreement.compare(
        study.utility, again, range(PLACES), tested=some.tested
    )["mean"]
    assert rho.rho == pytest.approx(1)
    assert first == second


@pytest.mark.slow
def test_a_classifier_is_compared_with_itself_by_another_seed(study, monkeypatch, capsys):
    monkeypatch.setattr(classifier_agreement.StudyResults, "load", lambda _: study)

    def printed(*options):
        monkeypatch.setattr("sys.argv", ["classifier_agreement", "results", *options])
        classifier_agreement.main()
        return {line[:24].strip(): line[24:].split() for line in capsys.readouterr().out.splitlines()}

    lines = printed("--classifier", "trees", "--other-seed", "1")
    assert lines["trees, both seeds"][-2] == lines["mean"][-1]
    assert lines["trees, both seeds"][-1] != lines["mean"][-1]
    again = printed("--classifier", "ridge", "--other-seed", "1")["ridge, both seeds"]
    assert (float(again[0]), again[-2]) == (1, again[-1])  # it draws nothing
    with pytest.raises(SystemExit):
        printed("--classifier", "multi3net", "--folds", "0", "--other-seed", "1")
