# SPDX-License-Identifier: GPL-3.0-or-later
"""What a data set's simulated side takes from libraries."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from headless.validation.unpaired import load_motions
from w2w.core.validation.mhad import MHAD
from w2w.core.validation.mighar import mighar

PROTOCOL = mighar({"here": 100, "there": 3000})


def test_a_library_of_which_nothing_is_used_is_said(shared_data, bundled_body, tmp_path):
    """As UTD-MHAD's folder with its npz in it, in place of the npz or of the .mat files."""
    library = tmp_path / "library"
    library.mkdir()
    shutil.copy(shared_data / "bvh" / "bandai_namco" / "dataset-1_walk_active_001.bvh", library)
    utd = tmp_path / "utd_mhad"
    utd.mkdir()
    np.savez(utd / "all.npz", a1_s1_t1_imu=np.zeros((9, 6)))
    told = []
    motions, _ = load_motions(PROTOCOL, [library, utd], bundled_body, told.append)
    assert len(motions) == 1
    assert len(told) == 1
    assert told[0].startswith(f"Nothing of {utd} is used: no file has a name that ")
    assert "UTD-MHAD is read from the folder of Inertial and Skeleton" in told[0]
    with pytest.raises(ValueError, match=r"no clip of the libraries can be used: .* Berkeley MHAD shows"):
        load_motions(MHAD, [utd], bundled_body)
    without = replace(MHAD, rules=tuple(rule for rule in MHAD.rules if rule.source != "UTD-MHAD"))
    with pytest.raises(ValueError, match=r"Berkeley MHAD shows$"):
        load_motions(without, [utd], bundled_body)


def test_a_kinects_folder_of_sensors_alone_is_said(bundled_body, tmp_path):
    (tmp_path / "a1_s1_t1_inertial.mat").touch()
    with pytest.raises(ValueError, match=r"holds no motion files .*UTD-MHAD is read from"):
        load_motions(PROTOCOL, [tmp_path], bundled_body)
