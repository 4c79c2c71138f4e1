# SPDX-License-Identifier: GPL-3.0-or-later
"""What a data set's simulated side takes from libraries, and that libraries do not change one another's."""

import shutil
import tarfile
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import savemat

from w2w_studies.comparisons import unpaired
from w2w_studies.comparisons.by_protocol import worn_sides
from w2w_studies.comparisons.unpaired import RegionSimulator, load_motions
from w2w_studies.datasets.mighar import WornAt
from w2w_studies.validation.mhad import MHAD
from w2w_studies.validation.mighar import mighar
from w2w_studies.validation.upfall import UPFALL, WITHOUT_POCKET

PROTOCOL = mighar(WornAt((0, 1), {"here": 100, "there": 3000}, np.array([0, 1])))
STYLES = {"one": ("active", "angry"), "two": ("childish",)}


@pytest.fixture
def libraries(shared_data, tmp_path):
    """Walks in two folders; the second also holds a walk of the first, under a name that comes before it."""
    walks = shared_data / "bvh" / "bandai_namco"
    folders = []
    for name, styles in STYLES.items():
        folders.append(tmp_path / name / "walking")
        folders[-1].mkdir(parents=True)
        for style in styles:
            shutil.copy(walks / f"dataset-1_walk_{style}_001.bvh", folders[-1])
    again = "dataset-1_walk_absent_001.bvh"
    shutil.copy(walks / "dataset-1_walk_active_001.bvh", folders[1] / again)
    return [folder.parent for folder in folders]


@pytest.fixture
def few_patches(monkeypatch):
    sample = unpaired.sample_patches
    monkeypatch.setattr(unpaired, "sample_patches", lambda body: sample(body, 16))


def bytes_of(recordings, names):
    """Signals of clips by their own names."""
    return {
        name: recording.acc.tobytes() + recording.gyr.tobytes()
        for name, recording in zip(names, recordings, strict=True)
    }


@pytest.mark.slow
@pytest.mark.usefixtures("few_patches")
def test_a_clips_signals_do_not_depend_on_other_libraries(libraries, bundled_body):
    simulator = RegionSimulator(bundled_body, PROTOCOL)

    def signals(*given):
        motions, _ = load_motions(PROTOCOL, given, bundled_body)
        recordings = [simulator.record(moving, 3.0) for moving in motions]
        assert [r.clip for r in recordings] == [moving.motion.clip for moving in motions]
        return bytes_of(recordings, [moving.own_name for moving in motions])

    one, two = libraries
    both = signals(one, two)
    assert len(set(both.values())) == len(both) == 4
    assert signals(two, one) == both
    assert signals(one) | signals(two) == both


@pytest.mark.usefixtures("few_patches")
def test_a_motion_in_two_libraries_is_one_clip(libraries, bundled_body):
    motions, _ = load_motions(PROTOCOL, libraries, bundled_body)
    clips = {moving.own_name: moving.motion.clip for moving in motions}
    assert clips["walking_dataset_1_walk_absent_001"] == clips["walking_dataset_1_walk_active_001"]
    assert len(set(clips.values())) == 3


def test_a_library_of_which_nothing_is_used_is_said(libraries, bundled_body, tmp_path):
    """As UTD-MHAD's folder with its npz in it, in place of the npz or of the .mat files."""
    utd = tmp_path / "utd_mhad"
    utd.mkdir()
    np.savez(utd / "all.npz", a1_s1_t1_imu=np.zeros((9, 6)))
    told = []
    motions, _ = load_motions(PROTOCOL, [libraries[0], utd], bundled_body, told.append)
    assert len(motions) == 2
    assert len(told) == 1
    assert told[0].startswith(f"Nothing of {utd} is used: no file has a name that ")
    assert "UTD-MHAD is read from the folder of Inertial and Skeleton" in told[0]
    with pytest.raises(ValueError, match=r"no clip of the libraries can be used: .* Berkeley MHAD shows"):
        load_motions(MHAD, [utd], bundled_body)
    without = replace(MHAD, rules=tuple(rule for rule in MHAD.rules if rule.source != "UTD-MHAD"))
    with pytest.raises(ValueError, match=r"Berkeley MHAD shows$"):
        load_motions(without, [utd], bundled_body)


@pytest.mark.slow
def test_who_lacks_a_sensor_is_said_and_takes_part_at_the_other_sites(libraries, shared_data, tmp_path):
    with tarfile.open(shared_data / "imu" / "up_fall" / "up_fall.tar.xz") as archive:
        for member in archive:
            if member.name.endswith(("Subject1Activity6Trial1.csv", "Subject5Activity6Trial1.csv")):
                archive.extract(member, tmp_path / "up_fall", filter="data")
    worn = UPFALL.read(tmp_path / "up_fall")
    simulate = unpaired.library_simulation(UPFALL, libraries, 0, lambda _: None)
    analyses = (UPFALL.analyses[0], WITHOUT_POCKET)
    whole, without_pocket = (worn_sides(UPFALL, worn, simulate, analysis) for analysis in analyses)
    assert set(whole.real.windows.subject) == {"s01"}
    assert whole.notes[-1] == "People of whom no clip can be used: s05."
    assert set(without_pocket.real.windows.subject) == {"s01", "s05"}
    assert without_pocket.sites == ("ankle", "belt", "neck", "wrist")
    assert set(without_pocket.site_of) == set(range(4))


def test_a_kinects_folder_of_sensors_alone_is_said(bundled_body, tmp_path):
    (tmp_path / "a1_s1_t1_inertial.mat").touch()
    with pytest.raises(ValueError, match=r"holds no motion files .*UTD-MHAD is read from"):
        load_motions(PROTOCOL, [tmp_path], bundled_body)


@pytest.mark.slow
def test_a_folder_of_a_kinect_and_motion_files_gives_both(libraries, bundled_body):
    name, folder = "a23_s1_t1", libraries[1]
    savemat(folder / f"{name}_inertial.mat", {"d_iner": np.zeros((60, 6))})
    savemat(folder / f"{name}_skeleton.mat", {"d_skel": np.zeros((20, 3, 20))})
    motions, unusable = load_motions(PROTOCOL, [folder], bundled_body)
    assert len(motions) == 2
    assert [reason.split(":")[0] for reason in unusable] == [name]
    assert len(load_motions(PROTOCOL, libraries, bundled_body)[0]) == 4
