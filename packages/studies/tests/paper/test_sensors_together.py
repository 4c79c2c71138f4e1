# SPDX-License-Identifier: GPL-3.0-or-later
"""Chosen sensors tested together by the run's own classifier, where that is a network on their windows."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.core.ranking import utility
from w2w.core.study.clip_files import features_file, write_features
from w2w.core.study.ranking import LabelledClip
from w2w.core.study.results import StudyResults
from w2w.headless.runs.folder import make_folders
from w2w_studies.classifiers.multi3net.classifier import Multi3Net
from w2w_studies.paper.joint_test import sensors_together

RATE, SAMPLES, CLIPS = 25.0, 50, 8
MOVES = {"rest": (0, 0), "wave": (1, 0), "step": (0, 1), "march": (1, 1)}
"""Whether the first and the second sensor move: neither tells more than two kinds apart."""


class Spied(Multi3Net):
    """Remembers how many channels it was given."""

    channels: list[int]

    def predict_folds(self, windows, *others):
        self.channels.append(windows.shape[3])
        return super().predict_folds(windows, *others)


@pytest.fixture
def study(tmp_path):
    """Two sensors, four activities, a window a clip."""
    rng = np.random.default_rng(0)
    make_folders(tmp_path)
    time = np.arange(SAMPLES)[:, None, None] / RATE
    clips = []
    for activity, moves in MOVES.items():
        for number in range(CLIPS):
            name = f"{activity}_{number}"
            swing = np.sin(2 * np.pi * (2 * time + rng.uniform(0, 0.1))) * np.array(moves)[:, None]
            signals = (3 * swing + rng.normal(0, 0.3, (2, SAMPLES, 2, 3))).astype(np.float32)
            ImuRecording(*signals, RATE).save(tmp_path / "signals" / f"{name}.npz")
            clips.append(LabelledClip(name, activity, "", name))
            write_features(
                features_file(tmp_path, name),
                np.zeros((1, 2, 1), np.float32),
                np.ones(1, bool),
                np.zeros(1),
            )
    windows = {"length_s": 2.0, "stride_s": 1.0}
    parameters = {"classifier": "multi3net", "by_subject": False, "folds": 4, "seed": 0, "windows": windows}
    return StudyResults(tmp_path, None, tuple(clips), parameters, None)


@pytest.mark.slow
def test_one_network_reads_the_windows_of_all_sensors(study, monkeypatch):
    pytest.importorskip("torch")
    monkeypatch.setattr(Spied, "channels", [], raising=False)
    small = partial(Spied, width=8, hidden=16, embedding=8, batch_size=16, epochs=40)
    monkeypatch.setitem(utility.CLASSIFIERS, "multi3net", SimpleNamespace(load=lambda: small))
    alone, together = sensors_together(study, [1, 0])
    assert (alone.classifier, together.classifier) == ("multi3net", "multi3net")
    assert Spied.channels == [12, 6]  # what takes longest first
    assert alone.mean[0] < 0.7
    assert together.mean[0] > 0.9
