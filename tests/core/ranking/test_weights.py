# SPDX-License-Identifier: GPL-3.0-or-later
"""Background and weights: what counts in the mean, in the map, its promise and the sets chosen by it."""

from dataclasses import fields, replace

import numpy as np
import pytest

from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import UtilityMap, utility_map, weighed
from w2w.core.ranking.weights import (
    check_counting,
    counting,
    known_mean,
    mean_over,
    read_weights,
)
from w2w.core.selection.headline import mean_sentence, mean_title
from w2w.core.selection.scored import best_single
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import LabelledClip, WindowLabels
from w2w_studies.paper.subsets import counted_columns
from w2w_studies.placements.comparison import compare_patches
from w2w_studies.placements.score_table import score_table

NAMES = ("bow", "jump", "run", "walk")
N = 8


def library(seed=0, clips=8):
    """Patches 0 to 3 tell bow from jump, the others run from walk, each the better the higher its number."""
    rng = np.random.default_rng(seed)
    clip = np.repeat(np.arange(4 * clips), 3)
    activity = np.repeat(np.arange(4), 3 * clips)
    features = rng.normal(size=(len(clip), N, 5)) + rng.normal(size=(4 * clips, N, 5))[clip]
    side = np.where(activity % 2, 1.0, -1.0)
    for patch in range(N):
        features[:, patch, 0] += np.where(
            activity // 2 == patch // 4, (1 + patch % 4) * side * (1 if patch < 4 else 0.5), 0
        )
        features[:, patch, 1] += 4.0 * (activity // 2 == patch // 4)
    return features.astype(np.float32), np.array(NAMES)[activity], clip


def protocol_by(counts=None, folds=5):
    _, activity, clip = library()
    return CrossValidation(activity, clip, None, np.ones(len(clip), dtype=bool), NAMES, folds, counts=counts)


def ranked(counts=None, classifier="ridge", folds=5, **options):
    return utility_map(library()[0], protocol_by(counts, folds), classifier, resamples=40, **options)


@pytest.fixture(scope="module")
def plain():
    return ranked()


def same(one, other):
    for field in fields(UtilityMap):
        np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name), field.name)


@pytest.mark.slow
def test_equal_weights_change_no_bit(plain, tmp_path):
    np.testing.assert_array_equal(plain.mean, plain.f1.mean(axis=1))
    same(ranked({}), plain)
    threefold = ranked(dict.fromkeys(NAMES, 3.0))
    np.testing.assert_array_equal(threefold.weights, np.full(4, 3.0))
    object.__setattr__(threefold, "weights", plain.weights)
    same(threefold, plain)
    plain.save(tmp_path / "plain.npz")
    with np.load(tmp_path / "plain.npz") as content:
        assert "weights" not in content
    same(UtilityMap.load(tmp_path / "plain.npz"), plain)
    assert mean_sentence(plain) == ""
    assert mean_title(plain) == "All activities (mean)"


@pytest.mark.parametrize("counts", [{"bow": 0.0, "run": 2.5}, {}])
def test_a_map_weighed_anew_is_the_one_that_training_gives(counts, tmp_path, monkeypatch):
    before, trained = ranked({"jump": 3.0}), ranked(counts)
    before.save(tmp_path / "map.npz")
    monkeypatch.setattr(Ridge, "predict_splits", None)
    found = weighed(UtilityMap.load(tmp_path / "map.npz"), protocol_by(counts), Pooling.none(N))
    same(found, trained)
    assert not np.array_equal(found.expected_mean, before.expected_mean)


def test_a_map_without_this_plans_trials_cannot_be_weighed_anew(plain):
    damaged = [replace(plain, trial_f1=f1) for f1 in (plain.trial_f1[:, :2], plain.trial_f1.astype(str))]
    for utility in (ranked(halvings=0), ranked(halvings=2), *damaged):
        assert weighed(utility, protocol_by({"bow": 0.0}), Pooling.none(N)) is None


@pytest.mark.later
def test_background_is_trained_against_and_not_counted(plain, tmp_path):
    counts = counting(NAMES, ["BOW", " jump"])
    utility = ranked(counts)
    np.testing.assert_array_equal(utility.predictions, plain.predictions)
    np.testing.assert_array_equal(utility.f1, plain.f1)
    np.testing.assert_allclose(utility.mean, plain.f1[:, 2:].mean(axis=1))
    assert best_single(plain) < 4
    assert best_single(utility) >= 4
    assert best_single(ranked(counting(NAMES, ["run", "walk"]))) < 4
    assert utility.expected_mean[4:].max() > utility.expected_mean[:4].max()
    assert (utility.mean_low <= utility.mean).all()
    assert (utility.mean <= utility.mean_high).all()
    assert utility.rank_high[best_single(utility)] <= 4
    utility.save(tmp_path / "map.npz")
    same(UtilityMap.load(tmp_path / "map.npz"), utility)
    assert mean_sentence(utility) == (
        "The mean is over 2 of 4 activities (run, walk); "
        "background, trained against and not counted: bow, jump"
    )
    assert mean_title(utility) == "Activities that count (mean)"


def test_weights_weigh_every_mean(plain):
    given = {"bow": 3.0, "walk": 0.5, "jump": 0.0}
    utility, shares = ranked(given), np.array([3.0, 0.0, 1.0, 0.5]) / 4.5
    np.testing.assert_allclose(utility.mean, plain.f1 @ shares, rtol=1e-5)
    np.testing.assert_allclose(
        counted_columns(utility.f1, utility.weights).mean(axis=1), utility.mean, rtol=1e-5
    )
    assert utility.mean.dtype == plain.mean.dtype == np.float32
    drawn = utility.mean_samples
    np.testing.assert_allclose(np.quantile(drawn, 0.025, axis=0), utility.mean_low, atol=1e-6)
    level = float((plain.f1.mean(axis=0) * shares).sum())
    assert float(utility.expected_mean.mean()) == pytest.approx(level, abs=0.05)
    text = mean_sentence(utility)
    assert "weighted (bow 3, run 1, walk 0.5)" in text
    assert text.endswith("not counted: jump")


def test_as_often_as_an_activity_is_counted_it_weighs(plain):
    """Twice the weight is what two activities of the same scores would be."""
    f1 = plain.f1
    np.testing.assert_allclose(
        mean_over(f1, np.array([2.0, 1, 1, 1])), np.column_stack([f1[:, :1], f1]).mean(axis=1), rtol=1e-6
    )
    holes = np.where(np.random.default_rng(0).random((5, 4)) < 0.3, np.nan, 0.5 + np.arange(4.0))
    holes[:, 3] = 1.0
    expected = np.nanmean(np.column_stack([holes, holes[:, 3:]]), axis=1)
    np.testing.assert_allclose(known_mean(holes, np.array([1.0, 1, 1, 2])), expected)


@pytest.mark.later
def test_tables_and_comparisons_follow(plain):
    utility = ranked({"bow": 3.0, "jump": 0.0})
    groups = {"bow": "a", "run": "a", "jump": "b", "walk": "b"}
    rows = {(row.group, row.activity): row for row in score_table(utility, [0, 4], groups)}
    f1 = plain.f1[[0, 4]]
    np.testing.assert_allclose(rows["a", ""].f1, (3 * f1[:, 0] + f1[:, 2]) / 4, rtol=1e-5)
    np.testing.assert_allclose(rows["b", ""].f1, f1[:, 3], rtol=1e-5)
    np.testing.assert_allclose(rows["", ""].f1, utility.mean[[0, 4]], rtol=1e-5)
    np.testing.assert_allclose(rows["b", "jump"].f1, f1[:, 1], rtol=1e-5)
    difference = compare_patches(utility, [0], [4]).difference[0, 0]
    assert difference == pytest.approx(float(utility.mean[0] - utility.mean[4]), abs=1e-6)
    background = compare_patches(utility, [0], [4], ["jump"]).f1
    np.testing.assert_allclose(background, plain.f1[[0], 1])


@pytest.mark.slow
def test_one_definition_for_every_classifier():
    """What a study's config says goes to the ranking and to tests of sets alike."""
    clips = [LabelledClip(f"{name} {number}", name) for name in NAMES for number in range(2)]
    labels = WindowLabels(
        np.array([clip.activity for clip in clips]),
        np.array([clip.name for clip in clips]),
        np.full(len(clips), ""),
        np.ones(len(clips), bool),
    )
    config = StudyConfig(background=("Walk",), weights=(("run", 2.0), ("bow", 1.0)))
    assert labels.protocol(config).counts == {"walk": 0.0, "run": 2.0}
    assert labels.protocol(StudyConfig()).counts == {}
    assert StudyConfig.from_dict(config.as_dict()) == config
    trees = ranked({"bow": 0.0, "jump": 0.0}, classifier="trees", folds=2)
    np.testing.assert_allclose(trees.mean, trees.f1[:, 2:].mean(axis=1))


@pytest.mark.parametrize(
    ("background", "weights", "message"),
    [
        (["runing"], [], "background: no clip is labelled runing; there are bow, jump, run, walk"),
        ([], [("crawl", 2.0)], "weights: no clip is labelled crawl"),
        (NAMES, [], "none of the activities that can be tested counts"),
        (["bow"], [("jump", 0.0), ("run", 0.0), ("walk", 0.0)], "none of the activities"),
        (["Bow"], [("bow", 2.0)], "bow: background has no weight"),
    ],
)
def test_what_cannot_be_meant_is_refused(background, weights, message):
    with pytest.raises(ValueError, match=message):
        check_counting(NAMES, background, weights)


def test_activities_that_count_but_cannot_be_tested_leave_nothing():
    features, activity, clip = library()
    keep = (activity != "bow") | (clip == 0)
    message = r"none of the activities that can be tested counts \(jump, run, walk\)"
    with pytest.raises(ValueError, match=message):
        utility_map(
            features[keep],
            CrossValidation(
                activity[keep],
                clip[keep],
                None,
                np.ones(keep.sum(), bool),
                NAMES,
                counts=counting(NAMES, NAMES[1:]),
            ),
        )


def test_a_table_of_weights_is_read(tmp_path):
    file = tmp_path / "weights.csv"
    file.write_text("Activity;Weight\nsit to stand;2.5\nwalk;0\n", encoding="utf-8-sig")
    assert read_weights(file) == (("sit to stand", 2.5), ("walk", 0.0))
    for text, message in (
        ("activity,weight\nwalk,much\n", "weights.csv, line 2: 'much' is no number"),
        ("activity,weight\nwalk,-1\n", "line 2: a weight is 0 .background. or more, not -1"),
        ("activity,weight\nwalk,nan\n", "line 2: a weight"),
        ("activity,weight\nwalk,1\nwalk,2\n", "line 3: 'walk' is listed twice"),
        ("activity,weight\n,1\n", "line 2: no activity"),
        ("activity,group\nwalk,a\n", "'activity' and 'weight'"),
    ):
        file.write_text(text)
        with pytest.raises(ValueError, match=message):
            read_weights(file)
    with pytest.raises(ValueError, match="weight of 'walk'"):
        StudyConfig(weights=(("walk", -1.0),))
