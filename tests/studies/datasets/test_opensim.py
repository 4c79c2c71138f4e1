# SPDX-License-Identifier: GPL-3.0-or-later
"""An OpenSim model's frames, from its coordinates, turn as OpenSim itself turns them."""

import gzip

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.studies.datasets.opensim import frame_poses, read_table

MODEL = "OpenSimMOCOModelWithContactGeometry_placed.osim.gz"


def test_frames_turn_as_in_opensim(shared_data):
    folder = shared_data / "imu" / "capsense"
    names, values = read_table(folder / "IKoutput_20to65secs.mot.gz")
    poses = frame_poses(folder / MODEL, dict(zip(names, values[::20, :, 0].T, strict=True)))
    theirs, quaternions = read_table(folder / "VirtualIMUProfiles_orientations.sto.gz")
    assert len(theirs) == 9
    for site, turns in zip(theirs[1:], quaternions[::20].transpose(1, 0, 2)[1:], strict=True):
        ours = Rotation.from_matrix(poses[site.removesuffix("_imu")][:, :3, :3])
        apart = (ours.inv() * Rotation.from_quat(turns[:, [1, 2, 3, 0]])).magnitude()
        assert np.degrees(np.median(apart)) < 0.25, site  # OpenSim low-passed its own


def test_a_joint_that_is_not_known_is_refused(tmp_path, shared_data):
    text = gzip.decompress((shared_data / "imu" / "capsense" / MODEL).read_bytes()).decode()
    path = tmp_path / "model.osim.gz"
    path.write_bytes(gzip.compress(text.replace("PinJoint", "SliderJoint").encode()))
    with pytest.raises(ValueError, match="SliderJoint"):
        frame_poses(path, {name: np.zeros(1) for name in _coordinates(text)})


def _coordinates(text):
    return [part.partition('"')[0] for part in text.split('<Coordinate name="')[1:]]
