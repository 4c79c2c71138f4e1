# SPDX-License-Identifier: GPL-3.0-or-later
"""What was recorded of a clip is made again where the clip or the patches have changed, and nowhere else."""

from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from w2w.core.files import load_arrays, write_npz
from w2w.core.imu.recording import ImuRecording
from w2w.core.study.clip_files import features_file, signals_file, write_features
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import LabelledClip
from w2w.core.study.remade import REMADE, recordings_at
from w2w.core.study.results import StudyResults

CLIPS = tuple(LabelledClip(name, "walk", "ann") for name in "abc")


@dataclass
class Study:
    """A study that tells which clips it has made again; each records its own number of noisy samples."""

    out: Path
    read: object = "by a run"
    made: list[int] = field(default_factory=list)
    clips = CLIPS
    patches = SimpleNamespace(names=tuple("vwxyz"))
    recorded = StudyResults.recorded
    _made_by = None, StudyConfig()

    @property
    def places(self):
        return [(self.out, clip.name) for clip in self.clips]

    def recording(self, clip, patches):
        self.made.append(clip)
        signals = np.random.default_rng(clip).normal(size=(2, 40 + clip, 5, 3)).astype(np.float32)
        whole = ImuRecording(*signals, 50.0, self.patches.names, "walk", "ann", self.clips[clip].name)
        return whole.at(patches)


def touch(study, clip, content):
    path = features_file(study.out, study.clips[clip].name)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_features(path, np.full((1, 5, 2), content, np.float32), np.ones(1, bool), np.zeros(90, np.float16))


@pytest.fixture
def study(tmp_path):
    """A study whose clips were recorded at two patches."""
    made = Study(tmp_path)
    for clip in range(3):
        touch(made, clip, clip)
    recordings_at(made, [0, 1, 2], [3, 1])
    made.made.clear()
    return made


def same(found, wanted):
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(one.values, other.values)
        assert (one.rate, one.sites, one.activity, one.subject, one.clip) == (
            other.rate, other.sites, other.activity, other.subject, other.clip,
        )  # fmt: skip


@pytest.mark.parametrize("read", ["by a run", None])
def test_clips_that_have_not_changed_are_not_made_again(study, read):
    study.read = read
    before = (study.out / REMADE).read_bytes()
    found = recordings_at(study, [0, 1, 2], [3, 1])
    assert not study.made
    assert (study.out / REMADE).read_bytes() == before
    same(found, [study.recording(clip, [3, 1]) for clip in range(3)])


def test_a_clip_that_has_changed_is_made_again_and_leaves_what_a_first_run_leaves(study):
    touch(study, 1, 7)
    recordings_at(study, [0, 1, 2], [3, 1])
    assert study.made == [1]
    first = (study.out / REMADE).read_bytes()
    (study.out / REMADE).unlink()
    recordings_at(study, [0, 1, 2], [3, 1])
    assert (study.out / REMADE).read_bytes() == first


def test_other_patches_are_made_again_and_the_first_ones_stay_kept(study):
    study.read = None
    same(recordings_at(study, [0, 2], [3, 0]), [study.recording(clip, [3, 0]) for clip in (0, 2)])
    study.read = "by a run"
    recordings_at(study, [0, 1, 2], [0, 2])
    study.made.clear()
    study.read = None
    recordings_at(study, [2, 0], [3, 1])
    assert not study.made


def other(**arrays):
    """Arrays in place of some of the file's own."""

    def spoil(path):
        write_npz(path, load_arrays(path, ("keys", "ends", "patches", "values"), "") | arrays)

    return spoil


@pytest.mark.parametrize(
    "spoil",
    [
        lambda path: path.write_bytes(path.read_bytes()[:-900]),
        lambda path: path.write_bytes(b""),
        other(values=np.zeros((123, 2, 5), np.float32)),
        other(values=np.full((123, 2, 6), np.inf, np.float32)),
        other(values=np.array("no numbers")),
        other(ends=np.array(["x", "y"])),
        other(ends=np.array([90, 20])),
        other(keys=np.zeros((3, 3))),
    ],
)
def test_a_damaged_file_is_made_again(study, spoil):
    path = study.out / REMADE
    whole = path.read_bytes()
    spoil(path)
    recordings_at(study, [0, 1, 2], [3, 1])
    assert 0 < len(study.made) <= 3
    same(recordings_at(study, [0, 1, 2], [3, 1]), [study.recording(clip, [3, 1]) for clip in range(3)])
    assert path.read_bytes() == whole


def test_who_only_reads_a_folder_leaves_it_as_it_is(study):
    touch(study, 1, 7)
    before, study.read = (study.out / REMADE).read_bytes(), None
    recordings_at(study, [0, 1, 2], [3, 1])
    assert study.made == [1]
    assert (study.out / REMADE).read_bytes() == before


def test_of_a_run_that_keeps_signals_nothing_else_is_kept(study):
    (signals := signals_file(study.out, "a")).parent.mkdir()
    signals.touch()
    recordings_at(study, [0, 1, 2], [3, 1])
    assert sorted(study.made) == [0, 1, 2]
    assert not (study.out / REMADE).exists()
