# SPDX-License-Identifier: GPL-3.0-or-later
"""Ranking from files some places at a time gives the bytes of ranking from memory, in bounded memory."""

import tracemalloc

import numpy as np
import pytest

from w2w.core.files import write_npz
from w2w.core.imu.recording import ImuRecording
from w2w.core.motion.signature import WIDTH
from w2w.core.ranking import f1
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.f1 import score_patches
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.study.clip_files import ClipWindows
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import LabelledClip, WindowLabels, same_motions
from w2w.core.windows.inputs import (
    ArrayBlocks,
    FeatureFiles,
    SomePatches,
    SomeWindows,
    StoredArray,
    WindowFiles,
    spans,
)
from w2w.core.windows.windows import WindowSpec, cut_windows

from ...rings import by_day

ACTIVITIES = ("bow", "jump", "run")


class Served(ArrayBlocks):
    """Serves an array and remembers how much was asked for at once."""

    def patches(self, which):
        self.__dict__.setdefault("asked", []).append(len(np.arange(self.shape[1])[which]))
        return super().patches(which).copy()


def library(n_places=10, n_clips=24, n_windows=4, width=9):
    rng = np.random.default_rng(0)
    clip = np.repeat(np.arange(n_clips), n_windows)
    label = clip % len(ACTIVITIES)
    centres = rng.normal(size=(len(ACTIVITIES), n_places, width))
    features = centres[label] + 2 * rng.normal(size=(len(clip), n_places, width))
    return features.astype(np.float32), np.array(ACTIVITIES)[label], clip, np.arange(len(clip)) % 2 == 0


def stored(utility: UtilityMap, path):
    utility.save(path)
    return path.read_bytes()


@pytest.mark.later
@pytest.mark.parametrize("places_at_once", by_day([3], [1, 3, 10]))
def test_the_size_of_the_blocks_changes_no_byte(tmp_path, places_at_once):
    features, activity, clip, is_test = library()
    protocol = CrossValidation(activity, clip, None, is_test, ACTIVITIES)
    source = Served(features)
    budget = places_at_once * features[:, 0].nbytes
    blockwise = utility_map(source, protocol, Ridge(block_bytes=budget), resamples=50)
    whole = utility_map(features, protocol, Ridge(), resamples=50)
    assert stored(blockwise, tmp_path / "a.npz") == stored(whole, tmp_path / "b.npz")
    assert max(source.asked) == places_at_once


def test_a_place_larger_than_the_budget_comes_alone():
    assert spans(ArrayBlocks(np.zeros((5, 3, 7))), 1) == [slice(0, 1), slice(1, 2), slice(2, 3)]
    assert spans(ArrayBlocks(np.zeros((5, 3, 7))), 5 * 7 * 4 * 2) == [slice(0, 2), slice(2, 3)]


def test_some_windows_of_a_source():
    array = np.arange(60.0).reshape(5, 4, 3)
    some = SomeWindows(ArrayBlocks(array), np.array([0, 3]))
    assert some.shape == (2, 4, 3)
    np.testing.assert_array_equal(some.patches(slice(1, 3)), array[[0, 3], 1:3])
    all_of_them = SomeWindows(ArrayBlocks(array), np.arange(5)).patches(slice(0, 4))
    assert np.shares_memory(all_of_them, array)


def test_of_files_only_the_wanted_windows_are_read(tmp_path):
    array = np.random.default_rng(3).normal(size=(40, 6, 50)).astype(np.float32)
    paths = [tmp_path / f"{number}.npz" for number in range(8)]
    for number, path in enumerate(paths):
        write_npz(path, {"features": array[5 * number : 5 * number + 5]})
    files = FeatureFiles(paths)
    for rows in ([0, 3, 4, 17, 39], range(40), [9, 2, 2]):
        rows = np.array(rows)
        np.testing.assert_array_equal(SomeWindows(files, rows).patches(slice(1, 4)), array[rows, 1:4])
        some = SomePatches(SomeWindows(files, rows), np.array([0, 1, 3, 5]))
        np.testing.assert_array_equal(some.patches(slice(1, 4)), array[rows][:, [1, 3, 5]])
    few = SomeWindows(files, np.array([7, 30]))
    tracemalloc.start()
    few.patches(slice(0, 6))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < array.nbytes / 4


def test_intervals_are_the_same_bytes_whatever_the_block(monkeypatch):
    rng = np.random.default_rng(1)
    truth, clip = np.arange(300) % 3, np.arange(300) // 3
    predictions = rng.integers(0, 3, size=(300, 11))
    whole = score_patches(truth, predictions, clip, 3, 40, 0.95, 7)
    monkeypatch.setattr(f1, "COUNT_BYTES", 2 * 3 * 4 * 100)  # two sensors' counts
    parts = score_patches(truth, predictions, clip, 3, 40, 0.95, 7)
    for a, b in zip([whole[0], *whole[1]], [parts[0], *parts[1]], strict=True):
        assert a.tobytes() == b.tobytes()


def test_a_part_of_a_stored_array(tmp_path):
    array = np.random.default_rng(2).normal(size=(6, 5, 4)).astype(np.float32)
    write_npz(tmp_path / "a.npz", {"other": np.arange(3), "features": array})
    found = StoredArray.find(tmp_path / "a.npz", "features")
    assert found.shape == array.shape
    np.testing.assert_array_equal(found.columns([(1, 3)]), array[:, 1:3])
    some = np.empty((2, 3, array.shape[2]), np.float32)
    found.read_columns([(0, 1), (2, 4)], np.array([0, 4]), some)
    np.testing.assert_array_equal(some, array[[0, 4]][:, [0, 2, 3]])
    content = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "a.npz").write_bytes(content[: found.offset + array.nbytes - 1])
    with pytest.raises(ValueError, match="was cut short"):
        found.columns([(1, 5)])


def test_files_that_cannot_be_read_in_parts_are_said(tmp_path):
    write_npz(tmp_path / "packed.npz", {"features": np.zeros((2, 2))}, compress=True)
    np.savez(tmp_path / "fortran.npz", features=np.asfortranarray(np.zeros((2, 3))))
    (tmp_path / "text.npz").write_text("no zip at all")
    with pytest.raises(ValueError, match="is compressed"):
        StoredArray.find(tmp_path / "packed.npz", "features")
    with pytest.raises(ValueError, match="does not hold the array 'signature'"):
        StoredArray.find(tmp_path / "packed.npz", "signature")
    with pytest.raises(ValueError, match="is not an array that W2W wrote"):
        StoredArray.find(tmp_path / "fortran.npz", "features")
    with pytest.raises(ValueError, match="does not hold the array"):
        StoredArray.find(tmp_path / "text.npz", "features")
    with pytest.raises(FileNotFoundError):
        StoredArray.find(tmp_path / "absent.npz", "features")


def recordings(tmp_path, lengths=(260, 60, 150), n_places=7):
    rng, paths, kept = np.random.default_rng(3), [], []
    for number, length in enumerate(lengths):
        acc, gyr = rng.normal(size=(2, length, n_places, 3))
        if number == 0:
            acc[5:40, 6] = np.nan  # a long gap of one sensor costs all of them the window
            gyr[200:202, 1] = np.nan
        kept.append(ImuRecording(acc, gyr, 50.0))
        paths.append(tmp_path / f"{number}.npz")
        kept[-1].save(paths[-1])
    return paths, kept


def test_windows_come_from_the_recordings_as_if_cut_whole(tmp_path):
    paths, kept = recordings(tmp_path)
    spec = WindowSpec()
    whole = [cut_windows(recording, spec).signals for recording in kept]
    windows = WindowFiles(paths, [len(part) for part in whole], spec)
    expected = np.concatenate(whole)
    assert windows.shape == expected.shape
    assert len(whole[0]) == 3  # of four, one has the gap
    for first, last in ((0, 7), (0, 1), (1, 2), (3, 6)):
        np.testing.assert_array_equal(windows.patches(slice(first, last)), expected[:, first:last])


def test_features_and_windows_from_files_have_the_shapes_that_classifiers_take(tmp_path):
    paths, kept = recordings(tmp_path)
    windows = [len(cut_windows(recording, WindowSpec()).signals) for recording in kept]
    feature_paths = [tmp_path / f"features{number}.npz" for number in range(len(kept))]
    for path, count in zip(feature_paths, windows, strict=True):
        write_npz(path, {"features": np.zeros((count, 7, 5), dtype=np.float32)})
    assert FeatureFiles(feature_paths).shape == (sum(windows), 7, 5)
    assert WindowFiles(paths, windows, WindowSpec()).shape == (sum(windows), 7, 100, 6)


def test_files_of_other_places_are_said(tmp_path):
    for number, width in enumerate((4, 5)):
        write_npz(tmp_path / f"{number}.npz", {"features": np.zeros((2, 3, width), dtype=np.float32)})
    with pytest.raises(ValueError, match=r"1\.npz holds features of shape \(3, 5\), others \(3, 4\)"):
        FeatureFiles([tmp_path / "0.npz", tmp_path / "1.npz"])


@pytest.mark.slow
def test_ranking_from_files_equals_memory_and_holds_one_block(tmp_path):
    n_clips, n_windows, n_places, width = 30, 5, 64, 150
    features, activity, clip, is_test = library(n_places, n_clips, n_windows, width)
    paths, clips, windows = [], [], []
    for number in range(n_clips):
        rows = clip == number
        paths.append(tmp_path / f"{number}.npz")
        write_npz(paths[-1], {"features": features[rows]})
        signature = np.random.default_rng(number).normal(size=5 * WIDTH)
        clips.append(LabelledClip(f"clip {number}", activity[rows][0], "", str(number)))
        windows.append(ClipWindows(is_test[rows], signature))
    config = StudyConfig()
    ranked = same_motions(clips, windows)
    protocol = WindowLabels.of(ranked, windows).protocol(config)
    utility = utility_map(features, protocol)
    assert [clip.motion_key for clip in ranked] == [clip.name for clip in clips]
    streamed = utility_map(FeatureFiles(paths), protocol)
    assert stored(streamed, tmp_path / "a.npz") == stored(utility, tmp_path / "b.npz")
    source = FeatureFiles(paths)
    tracemalloc.start()
    source.patches(slice(8, 12))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1.3 * features[:, 8:12].nbytes + 200_000
    assert features.nbytes > 10 * peak
