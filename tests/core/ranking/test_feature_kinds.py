# SPDX-License-Identifier: GPL-3.0-or-later
"""Which features describe a window, in the config, the results and the files of a study."""

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from w2w.core.imu.recording import ImuRecording
from w2w.core.ranking.feature_kinds import features_of
from w2w.core.ranking.features import window_features
from w2w.core.ranking.kernels import kernel_features
from w2w.core.study import StudyConfig, describe

WINDOWS = np.random.default_rng(0).normal(size=(3, 2, 100, 6)).astype(np.float32)


def test_both_are_the_one_beside_the_other():
    summary, kernels = window_features(WINDOWS, 50.0), kernel_features(WINDOWS, 3)
    np.testing.assert_array_equal(features_of(WINDOWS, 50.0), summary)
    np.testing.assert_array_equal(features_of(WINDOWS, 50.0, "minirocket", 3), kernels)
    np.testing.assert_array_equal(
        features_of(WINDOWS, 50.0, "both", 3), np.concatenate([summary, kernels], axis=2)
    )


def test_features_are_the_same_whatever_threads_there_are():
    """A product as large as this is split over two threads, which rounds otherwise."""
    windows = np.random.default_rng(4).normal(size=(2, 64, 200, 6)).astype(np.float32)
    found = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            found.append(features_of(windows, 100.0))
    np.testing.assert_array_equal(*found)


def test_an_unknown_word_is_refused():
    with pytest.raises(
        ValueError, match="no features are called 'rocket'; there are summary, minirocket, both"
    ):
        StudyConfig(features="rocket")
    with pytest.raises(ValueError, match="no features are called 'rocket'"):
        features_of(WINDOWS, 50.0, "rocket")


def test_the_config_says_which_and_signals_of_others_are_not_taken_up():
    both = StudyConfig(features="both")
    assert StudyConfig.from_dict(both.as_dict()) == both
    assert both.signal_parameters()["features"] == "both"
    assert "features" not in StudyConfig().signal_parameters()  # stored signals of earlier runs still do


def test_a_recording_is_described_as_the_config_says():
    rng = np.random.default_rng(1)
    recording = ImuRecording(*rng.normal(size=(2, 250, 2, 3)).astype(np.float32), 50.0)
    widths = {kind: describe(recording, StudyConfig(features=kind))[0].shape for kind in ("summary", "both")}
    assert widths["both"] == (*widths["summary"][:2], widths["summary"][2] + 336)
    seeds = [describe(recording, StudyConfig(features="minirocket", seed=seed))[0] for seed in (0, 1)]
    assert (seeds[0] != seeds[1]).any()
