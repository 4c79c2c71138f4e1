# SPDX-License-Identifier: GPL-3.0-or-later
"""What one classifier on the sensors reaches together, whatever the proxy promises."""

import numpy as np
import pytest

from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w_studies.paper.joint_test import joint_content, multi_sensor_check
from w2w_studies.paper.subsets import greedy_subset


def scores_of(*scores):
    return [
        {"sensors": number, "mean_f1": score, "mean_f1_interval": [score - 0.1, score + 0.1]}
        for number, score in enumerate(scores, start=1)
    ]


def test_a_set_that_gets_worse_with_each_sensor_is_headed_by_its_best():
    joint = joint_content(scores_of(0.56, 0.50, 0.42, 0.40, 0.36, 0.33), 0.9, chosen=10)
    assert (joint["sensors"], joint["mean_f1"], joint["reached"]) == (1, 0.56, False)
    assert joint["sentence"] == (
        "tested together, up to 6 sensors do not reach 0.9: F1 0.560 with 1 sensor at best, 0.330 with 6; "
        "more than 6 were not tested"
    )


def test_the_smallest_set_that_reaches_the_target_counts():
    joint = joint_content(scores_of(0.7, 0.91, 0.95), 0.9, chosen=3)
    assert (joint["sensors"], joint["reached"]) == (2, True)
    assert joint["sentence"] == "tested together, one classifier reaches F1 0.910 with 2 sensors (target 0.9)"


def test_what_other_clips_would_give_stands_first():
    together = scores_of(0.7, 0.91)
    for entry, expected in zip(together, (0.5, 0.6), strict=True):
        entry |= {"expected_f1": expected, "expected_f1_interval": [expected - 0.1, expected + 0.2]}
    joint = joint_content(together, 0.9, chosen=2)
    assert (joint["expected_f1"], joint["expected_f1_interval"]) == (0.6, [0.5, 0.8])
    assert joint["sentence"] == (
        "expected F1 0.600 on other clips with 2 sensors (95 % interval 0.50 to 0.80); on these clips, "
        "tested together, one classifier reaches F1 0.910 with 2 sensors (target 0.9)"
    )


def test_a_set_without_a_place_that_must_be_is_none():
    joint = joint_content(scores_of(0.95, 0.85, 0.92), 0.9, chosen=3, least=2)
    assert (joint["sensors"], joint["reached"]) == (3, True)


def test_nothing_is_said_of_sensors_that_were_not_tested_together():
    assert joint_content([], 0.9, chosen=3) is None


def test_several_sensors_together_are_tested_as_one():
    """Two sensors that each tell two of four activities apart tell all four together."""
    names = ("bow", "jump", "run", "walk")
    index, clip = np.repeat(np.arange(4), 40), np.arange(160) // 4
    features = np.random.default_rng(0).normal(size=(160, 3, 8)).astype(np.float32)
    features[:, 0, 0] += 20 * (index % 2)
    features[:, 1, 0] += 20 * (index // 2)
    activity = np.array(names)[index]
    protocol, classifier = (
        CrossValidation(activity, clip, None, np.ones(160, bool), names),
        Ridge(alphas=(0.1,)),
    )
    utility = utility_map(features, protocol, classifier, resamples=20)
    proxy = greedy_subset(utility.f1, 1.0, max_size=2)
    alone, together = multi_sensor_check((0, 1), features, protocol, classifier, resamples=20)
    assert alone.mean[0] == pytest.approx(utility.mean[0])
    assert together.mean[0] > 0.95
    assert proxy.mean_max_after_each[-1] < 0.75
