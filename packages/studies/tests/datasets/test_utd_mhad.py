# SPDX-License-Identifier: GPL-3.0-or-later
"""UTD-MHAD's own MATLAB files come in as the archive of arrays does."""

import numpy as np
import pytest
from scipy.io import savemat

from w2w_studies.datasets.dsads import read_dsads
from w2w_studies.datasets.utd_mhad import read_utd_mhad


@pytest.fixture
def folder(tmp_path):
    rng = np.random.default_rng(0)
    for part in ("Inertial", "Skeleton"):
        (tmp_path / part).mkdir()
    for name in ("a1_s2_t3", "a23_s1_t1"):
        savemat(tmp_path / "Inertial" / f"{name}_inertial.mat", {"d_iner": rng.normal(size=(151, 6))})
        savemat(tmp_path / "Skeleton" / f"{name}_skeleton.mat", {"d_skel": rng.normal(size=(20, 3, 51))})
    return tmp_path


def test_the_downloads_own_folder_is_read(folder, tmp_path):
    trials = read_utd_mhad(folder)
    assert [(t.recording.activity, t.recording.subject) for t in trials] == [
        ("swipe left", "s2"),
        ("walk", "s1"),
    ]
    assert [t.recording.sites for t in trials] == [("right wrist",), ("right thigh",)]
    assert trials[0].skeleton.shape == (51, 20, 3)
    assert trials[0].skeleton_rate == pytest.approx(50 * 50 / 150)
    arrays = {f"{t.recording.clip}_skel": t.skeleton for t in trials}
    arrays |= {
        f"{t.recording.clip}_imu": np.concatenate(
            [t.recording.acc[:, 0] / 9.80665, np.degrees(t.recording.gyr[:, 0])], 1
        )
        for t in trials
    }
    np.savez(tmp_path / "all.npz", **arrays)
    for one, other in zip(trials, read_utd_mhad(tmp_path / "all.npz"), strict=True):
        np.testing.assert_allclose(one.recording.acc, other.recording.acc, rtol=1e-5)
        np.testing.assert_allclose(one.recording.gyr, other.recording.gyr, rtol=1e-5)
        np.testing.assert_array_equal(one.skeleton, other.skeleton)


def test_wrong_files_are_refused_with_a_sentence(folder, tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(ValueError, match="holds no pairs"):
        read_utd_mhad(tmp_path / "empty")
    path = folder / "Inertial" / "a1_s2_t3_inertial.mat"
    savemat(path, {"other": np.ones(3)})
    with pytest.raises(ValueError, match="holds no array d_iner"):
        read_utd_mhad(folder)
    path.write_bytes(b"nothing at all, and certainly no MATLAB file" * 9)
    with pytest.raises(ValueError, match="no MATLAB file that can be read"):
        read_utd_mhad(folder)
    savemat(path, {"d_iner": np.ones((5, 4))})
    with pytest.raises(ValueError, match="must hold"):
        read_utd_mhad(folder)


@pytest.mark.parametrize("read", [read_utd_mhad, read_dsads])
def test_a_damaged_archive_is_said_by_name(tmp_path, read):
    path = tmp_path / "all.npz"
    np.savez(path, a1_s1_t1_imu=np.zeros((9, 6)), x=np.zeros((1, 125, 5, 6)))
    with pytest.raises(ValueError, match=r"all\.npz is no .* archive: it lacks .*(a1_s1_t1_skel|segment)"):
        read(path)
    path.write_bytes(path.read_bytes()[:300])
    with pytest.raises(ValueError, match=r"all\.npz is no .* archive: it cannot be read as an npz file"):
        read(path)
