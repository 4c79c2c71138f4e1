# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables and C3D files of bones: positions under the names of a rig instead of a joint set's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_NAMES, N_JOINTS
from w2w.core.keypoints.facts import PoseFacts, may_hold_joints
from w2w.core.keypoints.pose_files import read_joints
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.core.retargeting.bone_maps import bundled_bone_maps

RATE = 60.0
TIMES = np.arange(90) / RATE


@pytest.fixture(scope="module")
def places(bundled_body):
    """Joints (T, 24, 3), y up, of a person who lifts the left arm and the right knee."""
    turns = np.tile(np.eye(3), (len(TIMES), N_JOINTS, 1, 1))
    for joint, axis, size in (("left_shoulder", "y", -60), ("left_elbow", "z", -50), ("right_hip", "x", -40)):
        lifted = size * np.sin(3 * TIMES) ** 2
        turns[:, JOINT_NAMES.index(joint)] = Rotation.from_euler(axis, lifted, degrees=True).as_matrix()
    for side in ("left", "right"):  # so that it shows which way the knees bend
        knee = Rotation.from_euler("x", 20 + 30 * np.sin(3 * TIMES) ** 2, degrees=True)
        turns[:, JOINT_NAMES.index(f"{side}_knee")] = knee.as_matrix()
    path = np.array([0.0, 0.0, 0.95]) + TIMES[:, None] * [0.3, -0.2, 0]
    _, positions = joint_transforms(bundled_body, Motion(turns, path, RATE))
    return positions[..., [0, 2, 1]] * [1, 1, -1]


@pytest.fixture(scope="module")
def truth(places, bundled_body, tmp_path_factory):
    path = tmp_path_factory.mktemp("truth") / "truth.npy"
    np.save(path, places)
    return read_joints(path, PoseFacts(rate=RATE, up="y", joint_set="smpl-24")).fit(bundled_body).motion


def same(found, truth, body, degrees=6.0):
    """Whether a file's motion is the true one but for what a rig does not show: hands, spine."""
    motion = found.fit(body).motion
    assert motion.rate == pytest.approx(truth.rate, rel=1e-3)
    joints = [number for number, name in enumerate(JOINT_NAMES) if "hand" not in name and "wrist" not in name]
    off = (motion.rotations[:, joints].swapaxes(2, 3) @ truth.rotations[:, joints]).reshape(-1, 3, 3)
    assert np.degrees(Rotation.from_matrix(off).magnitude()).max() < degrees


def names_of(rig):
    """Bone of a map for each of the 24 joints, or None."""
    bones = next(bone_map for bone_map in bundled_bone_maps() if bone_map.name == rig).joints
    return [next(iter(bones.get(joint, ())), None) for joint in JOINT_NAMES]


def write(path, columns, table):
    np.savetxt(path, table, header=",".join(columns), delimiter=",", comments="", fmt="%10.6f")
    assert may_hold_joints(path)
    return path


def spread(names, places, form="{}.{}"):
    """Columns and numbers of the joints that have names."""
    known = [number for number, name in enumerate(names) if name]
    columns = [form.format(names[number], axis) for number in known for axis in "xyz"]
    return columns, places[:, known].reshape(len(places), -1)


@pytest.mark.parametrize("rig", ["Mixamo", "Rokoko", "OptiTrack", "Theia", "Acclaim (CMU, HDM05)", "Unreal"])
def test_bones_of_a_rig_are_the_joints_that_they_play(tmp_path, places, truth, bundled_body, rig):
    columns, numbers = spread(names_of(rig), 100 * places)
    table = np.column_stack([TIMES, numbers])
    found = read_joints(write(tmp_path / "a.csv", ["time", *columns], table))
    assert found.up == "y"
    same(found, truth, bundled_body)


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e6])
def test_rokoko_s_axes_are_left_handed_and_its_stamps_in_any_unit(
    tmp_path, places, truth, bundled_body, unit
):
    """Unity's axes: Rokoko's own description of its csv export."""
    columns, numbers = spread(names_of("Rokoko"), places * [-1, 1, 1], "{}_position_{}")
    turns = [column.replace("position", "rotation") for column in columns]
    table = np.column_stack([TIMES * unit, np.arange(len(TIMES)), numbers, np.full(numbers.shape, 0.5)])
    found = read_joints(write(tmp_path / "a.csv", ["Timestamp", "frame", *columns, *turns], table))
    same(found, truth, bundled_body)


def test_stamps_that_count_frames_give_no_rate(tmp_path, places, truth, bundled_body):
    columns, numbers = spread(names_of("Mixamo"), places)
    table = np.column_stack([np.arange(len(TIMES)), numbers])
    path = write(tmp_path / "a.csv", ["timestamp", *columns], table)
    with pytest.raises(UnusableMotion, match="it does not say its frame rate: give --pose-rate"):
        read_joints(path)
    same(read_joints(path, PoseFacts(rate=RATE)), truth, bundled_body)


def write_motive(path, people, space="Global"):
    """A table as Motive exports it: turns and places of bones, then a marker."""
    kinds, names, what, axes = ["", "Type"], ["", "Name"], ["", ""], ["Frame", "Time (Seconds)"]
    columns = [np.arange(len(TIMES)), TIMES]
    for person, places in people.items():
        for name, place in zip(names_of("OptiTrack"), places.swapaxes(0, 1), strict=True):
            if name:
                kinds += ["Bone"] * 7
                names += [f'"{person}:{name}"'] * 7
                what += ["Rotation"] * 4 + ["Position"] * 3
                axes += [*"XYZWXYZ"]
                columns += [*np.tile([[0.0], [0.0], [0.0], [1.0]], len(TIMES)), *place.T]
    kinds, names, what = (
        row + [last] * 3 for row, last in ((kinds, "Marker"), (names, "M"), (what, "Position"))
    )
    axes, columns = [*axes, *"XYZ"], [*columns, *np.zeros((3, len(TIMES)))]
    about = f"Format Version,1.23,Take Name,a,Length Units,Meters,Coordinate Space,{space}"
    head = [about, "", *map(",".join, (kinds, names, what, axes))]
    rows = [",".join(f"{value:.6f}" for value in row) for row in np.column_stack(columns)]
    path.write_text("\n".join([*head, *rows]) + "\n")
    assert may_hold_joints(path)
    return path


def test_motive_s_bones_of_the_first_person(tmp_path, places, truth, bundled_body):
    path = write_motive(tmp_path / "a.csv", {"Ada": places, "Bo": places + 1})
    found = read_joints(path)
    assert found.unit == "m"
    same(found, truth, bundled_body)
    with pytest.raises(UnusableMotion, match="it holds no bones in global coordinates"):
        read_joints(write_motive(tmp_path / "b.csv", {"Ada": places}, "Local"))


def test_angles_under_the_same_names_are_no_positions(tmp_path, places):
    """As bvh-toolbox writes them next to the positions: `walk01_rot.csv`."""
    columns, numbers = spread(names_of("Mixamo"), places)
    rng = np.random.default_rng(0)
    angles = np.cumsum(rng.normal(scale=2, size=numbers.shape), axis=0) + rng.normal(
        scale=20, size=numbers.shape[1]
    )
    with pytest.raises(UnusableMotion):
        read_joints(write(tmp_path / "walk_rot.csv", ["time", *columns], np.column_stack([TIMES, angles])))


def test_names_of_no_rig_are_said(tmp_path, places):
    columns, numbers = spread([f"part{letter}" for letter in "abcdefghijklmnopqrstuvwx"], places)
    with pytest.raises(UnusableMotion, match=r"names \(parta, .*, \.\.\.\) are of no joint set or bone map"):
        read_joints(write(tmp_path / "a.csv", columns, numbers), PoseFacts(rate=RATE))


def test_segments_of_a_c3d_file(tmp_path, places, truth, bundled_body):
    """Theia's: poses of segments, whose origins are the joints, and points that are no joints."""
    ezc3d = pytest.importorskip("ezc3d", exc_type=ImportError)
    made, names = ezc3d.c3d(), names_of("Theia")
    known = [number for number, name in enumerate(names) if name]
    made["parameters"]["POINT"]["RATE"]["value"] = [RATE]
    made["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    made["parameters"]["POINT"]["LABELS"]["value"] = ["ball"]
    made["data"]["points"] = np.ones((4, 1, len(TIMES)))
    segments = np.tile(np.eye(4)[:, :, None, None], (1, 1, len(known), len(TIMES)))
    segments[:3, 3] = 1000 * places[:, known].transpose(2, 1, 0)
    made["data"]["rotations"] = segments
    made.add_parameter("ROTATION", "LABELS", [f"{names[number]}_4X4" for number in known])
    made.write(str(tmp_path / "a.c3d"))
    found = read_joints(tmp_path / "a.c3d")
    assert (found.unit, found.up) == ("mm", "y")
    same(found, truth, bundled_body)


@pytest.mark.parametrize("file", ["bvhtoolbox_like.csv", "rokoko_like.csv"])
def test_tables_as_programs_leave_them(shared_cases, bundled_body, file):
    found = read_joints(shared_cases / "second/containers" / file)
    assert (found.n_frames, found.up, round(found.rate)) == (60, "y", 60)
    assert found.fit(bundled_body).motion.n_frames == 60
