# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished study read back."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.core.study.clip_files import signals_file
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import LabelledClip
from w2w.core.study.results import StudyResults


def test_some_patches_are_read_as_from_the_whole_recording(tmp_path: Path) -> None:
    rng, names = np.random.default_rng(0), tuple("abcde")
    whole = ImuRecording(*rng.normal(size=(2, 40, 5, 3)), 50.0, names, "walk", "ann", "one")
    (kept := signals_file(tmp_path, "one")).parent.mkdir()
    whole.save(kept)
    clip = LabelledClip("one", "walk", "ann")
    study = StudyResults(tmp_path, SimpleNamespace(names=names), (clip,), StudyConfig().as_dict(), None)
    study.__dict__["_made_by"] = None, StudyConfig()
    part, wanted = study.recording(0, [3, 1]), whole.at([3, 1])
    assert (part.sites, part.rate, part.activity, part.subject, part.clip) == (
        wanted.sites, wanted.rate, wanted.activity, wanted.subject, wanted.clip,
    )  # fmt: skip
    np.testing.assert_array_equal(part.values, wanted.values)
    kept.write_bytes(kept.read_bytes()[:-1000])
    with pytest.raises(ValueError, match="does not hold the array 'acc'"):
        study.recording(0, [3, 1])
