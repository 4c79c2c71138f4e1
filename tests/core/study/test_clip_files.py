# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips' windows come back in one order, as features and as windows."""

from types import SimpleNamespace

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.core.motion.signature import WIDTH
from w2w.core.study.clip_files import ClipWindows, Signatures, features_file, ranking_inputs, write_features
from w2w.core.study.ranking import same_motion_groups
from w2w.core.windows.windows import WindowSpec, cut_windows

SPEC = WindowSpec(length_s=1.0, stride_s=0.5)
WINDOWS = SimpleNamespace(name="", inputs="windows", predict_folds=print)


def test_clips_in_one_order(tmp_path):
    rng = np.random.default_rng(0)
    features, signals = [], []
    for clip, n_samples in (("a", 120), ("b", 80)):
        acc, gyr = rng.normal(size=(2, n_samples, 3, 3)).astype(np.float32)
        recording, path = ImuRecording(acc, gyr, 50.0, clip=clip), tmp_path / "signals" / f"{clip}.npz"
        path.parent.mkdir(parents=True, exist_ok=True)
        recording.save(path)
        windows = cut_windows(recording, SPEC)
        signals.append(windows.signals)
        features.append(rng.normal(size=(len(windows.is_test), 3, 7)).astype(np.float32))
        features_file(tmp_path, clip).parent.mkdir(parents=True, exist_ok=True)
        write_features(features_file(tmp_path, clip), features[-1], windows.is_test, np.arange(4.0))
    found = [ClipWindows.read(tmp_path, clip) for clip in "ab"]
    assert found[0].is_test.sum() == 2
    places = [(tmp_path, "a"), (tmp_path, "b")]
    as_features = ranking_inputs(places, found, "ridge", SPEC)
    np.testing.assert_array_equal(as_features.patches(slice(1, 3)), np.concatenate(features)[:, 1:3])
    as_windows = ranking_inputs(places, found, WINDOWS, SPEC)
    np.testing.assert_array_equal(as_windows.patches(slice(0, 2)), np.concatenate(signals)[:, :2])
    assert as_windows.shape[0] == as_features.shape[0] == sum(len(one.is_test) for one in found)


def test_signatures_come_back_from_their_file_and_none_is_empty(tmp_path):
    rng = np.random.default_rng(1)
    given = [rng.normal(size=length).astype(np.float16) for length in (5, 0, 7)]
    kept = Signatures(tmp_path)
    for one in given:
        kept.append(one)
    assert not list(tmp_path.iterdir())  # the file has no name, or none that stays
    assert len(kept) == 3
    for one, found in zip(given, kept, strict=True):
        np.testing.assert_array_equal(found, one)
    np.testing.assert_array_equal(kept[0], given[0])
    kept.close()


def test_motions_are_told_apart_by_signatures_in_a_file_as_by_those_in_memory(tmp_path):
    rng = np.random.default_rng(2)
    rows = rng.normal(size=(6, 5 * WIDTH)).astype(np.float16)
    rows[4] = rows[1]
    kept = Signatures(tmp_path)
    for row in rows:
        kept.append(row)
    names = list("abcdef")
    found = same_motion_groups(names, None, kept)
    np.testing.assert_array_equal(found, same_motion_groups(names, None, list(rows)))
    assert found[4] == found[1]
    assert len(set(found.tolist())) == 5
    kept.close()
