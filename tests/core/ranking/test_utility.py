# SPDX-License-Identifier: GPL-3.0-or-later
"""The utility map: honest by construction, leaks are caught, files round-trip, real sensors rank."""

import numpy as np
import pytest
from sklearn.metrics import f1_score

from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.selection.scored import best_single

ACTIVITIES = ("bow", "jump", "run", "walk")


def library(seed=0, clips_per_activity=10, windows_per_clip=5, n_features=20, signal=(0.0, 0.4, 3.0)):
    """Features whose clips differ far more from one another than their windows do.

    Sensor n carries the activity as strongly as signal[n].
    """
    rng = np.random.default_rng(seed)
    activity = np.repeat(ACTIVITIES, clips_per_activity * windows_per_clip)
    clip = np.repeat(np.arange(len(ACTIVITIES) * clips_per_activity), windows_per_clip)
    index = np.searchsorted(ACTIVITIES, activity)
    n_sensors = len(signal)
    centres = rng.normal(size=(len(ACTIVITIES), n_sensors, n_features)) * np.array(signal)[:, None]
    clips = rng.normal(size=(clip.max() + 1, n_sensors, n_features))
    features = centres[index] + clips[clip] + 0.05 * rng.normal(size=(len(clip), n_sensors, n_features))
    return features.astype(np.float32), activity, clip, np.arange(len(clip)) % 2 == 0


@pytest.mark.later
def test_labels_shuffled_by_clip_give_chance():
    features, activity, clip, is_test = library(clips_per_activity=20, signal=(3.0, 3.0, 3.0))
    label_of = activity[np.searchsorted(clip, np.arange(clip.max() + 1))]
    means = []
    for seed in range(4):
        shuffled = np.random.default_rng(seed).permutation(label_of)[clip]
        means.append(
            utility_map(
                features, CrossValidation(shuffled, clip, None, is_test, ACTIVITIES), resamples=20
            ).mean
        )
    assert np.mean(means) == pytest.approx(0.25, abs=0.04)
    assert (
        utility_map(
            features, CrossValidation(activity, clip, None, is_test, ACTIVITIES), resamples=20
        ).mean.min()
        > 0.95
    )


def test_a_planted_leak_is_caught():
    """Clips carry no activity but are recognisable.

    Taking windows for clips leaks them from training to test and looks excellent; by clips it is chance.
    """
    features, activity, clip, is_test = library(signal=(0.0,), clips_per_activity=15, n_features=40)
    honest = utility_map(features, CrossValidation(activity, clip, None, is_test, ACTIVITIES), resamples=200)
    leaked = utility_map(
        features, CrossValidation(activity, np.arange(len(clip)), None, is_test, ACTIVITIES), resamples=20
    )
    assert leaked.mean[0] > 0.6
    assert honest.mean[0] < 0.4
    assert honest.mean_low[0] < 0.25 < honest.mean_high[0]


def test_a_copy_of_a_clip_under_another_name_leaks_unless_grouped():
    features, activity, clip, is_test = library(signal=(0.0,), n_features=40)
    twice = np.concatenate([features, features])
    labels, test = np.tile(activity, 2), np.tile(is_test, 2)
    apart = utility_map(
        twice,
        CrossValidation(labels, np.concatenate([clip, clip + 1000]), None, test, ACTIVITIES),
        resamples=20,
    )
    grouped = utility_map(
        twice, CrossValidation(labels, np.tile(clip, 2), None, test, ACTIVITIES), resamples=20
    )
    assert apart.mean[0] > 0.6
    assert grouped.mean[0] < 0.4


def test_map_equals_scikit_learn_on_its_own_predictions_and_ranks_the_sensors():
    features, activity, clip, is_test = library()
    told = []
    utility = utility_map(
        features, CrossValidation(activity, clip, None, is_test, ACTIVITIES), progress=told.append
    )
    np.testing.assert_array_equal(np.array(ACTIVITIES)[utility.truth], activity[is_test])
    for sensor in range(3):
        expected = f1_score(utility.truth, utility.predictions[:, sensor], average=None)
        np.testing.assert_allclose(utility.f1[sensor], expected, rtol=1e-5)
    np.testing.assert_allclose(utility.mean, utility.f1.mean(axis=1))
    assert (np.diff(utility.mean) > 0.1).all()
    assert best_single(utility) == 2
    assert utility.rank_high[2] == 1
    assert (utility.f1_low <= utility.f1).all()
    assert (utility.f1 <= utility.f1_high).all()
    assert utility.confusion.sum() == 3 * is_test.sum()
    assert told[-1] == 1.0
    assert utility.protocol == "5-fold cross-validation grouped by clip"


def test_unused_activities_and_lonely_clips_are_left_out_with_a_sentence():
    features, activity, clip, is_test = library()
    activity = np.where(clip == 0, "lonely", activity)
    wanted = (*ACTIVITIES[1:], "lonely", "absent")
    utility = utility_map(features, CrossValidation(activity, clip, None, is_test, wanted), resamples=20)
    assert utility.activities == ACTIVITIES[1:]
    assert set(utility.left_out) == {"lonely", "absent"}
    assert len(utility.truth) == is_test[np.isin(activity, ACTIVITIES[1:])].sum()
    with pytest.raises(ValueError, match="lonely has only one clip"):
        utility_map(features, CrossValidation(activity, clip, None, is_test, ("lonely", "walk")))


def test_subjects_are_left_out_one_at_a_time():
    """Each person moves in a way of their own; a clip's other windows must not give it away."""
    features, activity, clip, is_test = library(signal=(0.0,), clips_per_activity=12)
    subject = np.char.add("s", (clip % 3).astype(str))
    habit = np.random.default_rng(5).normal(size=(3, len(ACTIVITIES), 20)) * 4
    features[:, 0] += habit[clip % 3, np.searchsorted(ACTIVITIES, activity)].astype(np.float32)
    by_clip = utility_map(features, CrossValidation(activity, clip, None, is_test, ACTIVITIES), resamples=20)
    by_subject = utility_map(
        features, CrossValidation(activity, clip, subject, is_test, ACTIVITIES), resamples=20
    )
    assert by_subject.protocol == "leave one of 3 subjects out"
    assert by_clip.mean[0] > 0.9
    assert by_subject.mean[0] < 0.6


def test_windows_only_for_training_are_not_tested_but_help():
    features, activity, clip, _ = library(signal=(1.2,), clips_per_activity=5, windows_per_clip=20)
    features += np.random.default_rng(0).normal(size=features.shape).astype(np.float32)
    is_test = np.arange(len(clip)) % 20 == 0
    alone, *labels = (part[is_test] for part in (features, activity, clip))
    few = utility_map(alone, CrossValidation(*labels, None, np.ones(is_test.sum(), bool), ACTIVITIES))
    many = utility_map(features, CrossValidation(activity, clip, None, is_test, ACTIVITIES))
    np.testing.assert_array_equal(many.truth, few.truth)
    assert many.mean[0] > few.mean[0] + 0.03


def test_same_seed_same_map_and_files_round_trip(tmp_path):
    features, activity, clip, is_test = library()
    maps = [
        utility_map(features, CrossValidation(activity, clip, None, is_test, ACTIVITIES, seed=3))
        for _ in range(2)
    ]
    for number, utility in enumerate(maps):
        utility.save(tmp_path / f"{number}.npz")
    assert (tmp_path / "0.npz").read_bytes() == (tmp_path / "1.npz").read_bytes()
    loaded = UtilityMap.load(tmp_path / "0.npz")
    assert loaded.activities == maps[0].activities
    assert loaded.left_out == maps[0].left_out
    assert (loaded.classifier, loaded.protocol, loaded.level) == ("ridge", maps[0].protocol, 0.95)
    for name in ("f1", "mean_samples", "predictions", "confusion", "rank_low", "clip"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(maps[0], name))
    np.savez(tmp_path / "other.npz", f1=maps[0].f1)
    with pytest.raises(ValueError, match=r"other\.npz is not a utility map: it lacks activities"):
        UtilityMap.load(tmp_path / "other.npz")
