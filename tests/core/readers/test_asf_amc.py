# SPDX-License-Identifier: GPL-3.0-or-later
"""Acclaim files: a motion written by their rules comes back, whatever way the bones' own axes stand."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import w2w
from w2w.core.body.body import JOINT_INDEX, PARENTS, Y_UP_TO_Z_UP
from w2w.core.motion.motion import Motion, read_amass
from w2w.core.motion.skinning import joint_transforms, on_the_ground
from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.asf_amc import read_amc, skeleton_file
from w2w.core.retargeting.retarget import retarget

SEGMENTS = {
    "root": "pelvis", "lowerback": "spine1", "upperback": "spine2", "thorax": "spine3",
    "lowerneck": "neck", "head": "head",
    **{
        f"{side[0]}{bone}": f"{side}_{joint}"
        for side in ("left", "right")
        for bone, joint in (
            ("clavicle", "collar"), ("humerus", "shoulder"), ("radius", "elbow"), ("wrist", "wrist"),
            ("fingers", "hand"), ("femur", "hip"), ("tibia", "knee"), ("foot", "ankle"), ("toes", "foot"),
        )
    },
}  # fmt: skip
INCH = 0.0254 / 0.45
"""Metres in CMU's unit of length."""


def write_acclaim(folder, body, motion, stem="07", take="07_01", seed=0):
    """An .asf and .amc of a motion on a body; a bone leads from a joint's parent to it, turned as its parent.

    A joint's own bone starts at the joint: between a parent and a child that does not lie at its end stands a
    bone without degrees of freedom, as CMU's lhipjoint.
    """
    rng = np.random.default_rng(seed)
    to_file = Y_UP_TO_Z_UP.T
    joints = body.joints @ to_file.T / INCH
    index = {bone: JOINT_INDEX[joint] for bone, joint in SEGMENTS.items()}
    of_joint = {number: bone for bone, number in index.items()}
    axes = {bone: rng.uniform(-180, 180, 3) for bone in SEGMENTS}
    data, tree = [], {"root": []}
    for bone, number in index.items():
        if bone == "root":
            continue
        parent = of_joint[PARENTS[number]]
        offset = joints[number] - joints[PARENTS[number]]
        link = f"{bone}link"
        tree.setdefault(parent, []).append(link)
        tree.setdefault(link, []).append(bone)
        length = np.linalg.norm(offset)
        data += ["begin", f"name {link}", "direction " + " ".join(f"{x:.9f}" for x in offset / length)]
        data += [f"length {length:.9f}", "axis 0 0 0 XYZ", "end"]
        data += ["begin", f"name {bone}", "direction 0 1 0", "length 0"]
        data += ["axis " + " ".join(f"{x:.9f}" for x in axes[bone]) + " XYZ", "dof rx ry rz"]
        data += ["limits (-180 180)", "(-180 180)", "(-180 180)", "end"]
    lines = [
        "# made", ":version 1.10", ":name VICON", ":units", "mass 1.0", "length 0.45", "angle deg", ":root",
        "order TX TY TZ RX RY RZ", "axis XYZ", "position 0 0 0", "orientation 0 0 0", ":bonedata", *data,
        ":hierarchy", "begin", *(f"{bone} {' '.join(below)}" for bone, below in tree.items()), "end",
    ]  # fmt: skip
    (folder / f"{stem}.asf").write_text("\n".join(lines) + "\n")
    turns = to_file @ motion.rotations @ to_file.T
    angles = {}
    for bone, number in index.items():
        own = (
            np.eye(3) if bone == "root" else Rotation.from_euler("xyz", axes[bone], degrees=True).as_matrix()
        )
        inner = own.T @ turns[:, number] @ own
        angles[bone] = Rotation.from_matrix(inner).as_euler("xyz", degrees=True)
    place = motion.pelvis @ to_file.T / INCH
    rows = ["#!made", ":FULLY-SPECIFIED", ":DEGREES"]
    for frame in range(motion.n_frames):
        rows.append(str(frame + 1))
        for bone in SEGMENTS:
            numbers = [*place[frame], *angles[bone][frame]] if bone == "root" else angles[bone][frame]
            rows.append(f"{bone} " + " ".join(f"{x:.9f}" for x in numbers))
    (folder / f"{take}.amc").write_text("\n".join(rows) + "\n")
    return folder / f"{take}.amc"


@pytest.fixture(scope="module")
def capture(shared_data, bundled_body):
    """A second of real motion capture on the bundled body."""
    motion = on_the_ground(
        bundled_body, read_amass(shared_data / "smpl_poses/nghorbani__amass/amass_sample.npz")
    )
    return Motion(motion.rotations[:120], motion.pelvis[:120], 120.0)


def test_joints_and_turns_come_back_whatever_the_bones_axes(bundled_body, capture, tmp_path):
    source = read_amc(write_acclaim(tmp_path, bundled_body, capture))
    assert source.rate == 120
    expected, positions = joint_transforms(bundled_body, capture)
    for bone, joint in SEGMENTS.items():
        number = source.bones.index(bone)
        found = source.matrices[:, number]
        np.testing.assert_allclose(INCH * found[:, :3, 3], positions[:, JOINT_INDEX[joint]], atol=1e-5)
        np.testing.assert_allclose(found[:, :3, :3], expected[:, JOINT_INDEX[joint]], atol=1e-6)
    carried = retarget(source, bundled_body)
    assert carried.bone_map == "Acclaim (CMU, HDM05)"
    assert carried.scale == pytest.approx(INCH, rel=1e-3)
    apart = expected.swapaxes(-1, -2) @ joint_transforms(bundled_body, carried.motion)[0]
    assert np.degrees(Rotation.from_matrix(apart.reshape(-1, 3, 3)).magnitude()).max() < 1


def test_python_loads_it_at_another_rate(bundled_body, capture, tmp_path):
    path = write_acclaim(tmp_path, bundled_body, capture)
    assert w2w.load(path)[0].rate == 120
    assert w2w.load(path, pose=w2w.PoseFacts(rate=60.0))[0].rate == 60
    folder = w2w.load(tmp_path)
    assert [motion.clip for motion in folder] == ["07_01"]


def test_the_skeleton_beside_it_is_found(tmp_path):
    for name in ("HDM_bd.asf", "HDM_bk.asf", "HDM_bd_cartwheel_001_120.amc", "other.amc"):
        (tmp_path / name).write_text("x")
    assert skeleton_file(tmp_path / "HDM_bd_cartwheel_001_120.amc").name == "HDM_bd.asf"
    with pytest.raises(UnusableMotion, match=r"several lie there \(HDM_bd\.asf, HDM_bk\.asf\)"):
        skeleton_file(tmp_path / "other.amc")
    (tmp_path / "HDM_bd.asf").unlink()
    assert skeleton_file(tmp_path / "other.amc").name == "HDM_bk.asf"
    (tmp_path / "HDM_bk.asf").unlink()
    with pytest.raises(UnusableMotion, match="none lies there"):
        skeleton_file(tmp_path / "other.amc")


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("asf", ":bonedata", ":bones", "its skeleton 07.asf is damaged: it lacks :bonedata"),
        ("asf", "angle deg", "angle rad", "its angles are in radians"),
        ("asf", "axis XYZ", "axis XXZ", "xxz is no order of axes"),
        ("asf", "root lowerbacklink", "root nosuch", "07.asf is damaged: 'nosuch'"),
        ("asf", "lowerbacklink lowerback\n", "", "does not lead from the root to"),
        ("asf", "length 0.45\n", "length 0.45\nangle rad\n", "its angles are in radians"),
        ("amc", ":DEGREES", ":RADIANS", "its angles are in radians"),
        ("amc", "\nhead ", "\nhaed ", "its frame 1 moves haed, which its skeleton does not"),
        ("amc", "\nhead ", "\nhead 1 ", "its frame 1 gives head other than 3 numbers"),
        ("amc", "\nhead ", "\nhead nan nan nan#", "not finite"),
        ("amc", "\n5\n", "\n#", ""),
    ],
)
def test_what_is_wrong_is_one_sentence(bundled_body, capture, tmp_path, file, old, new, message):
    short = Motion(capture.rotations[:6], capture.pelvis[:6], 120.0)
    path = write_acclaim(tmp_path, bundled_body, short)
    damaged = tmp_path / ("07.asf" if file == "asf" else "07_01.amc")
    text = damaged.read_text()
    assert old in text
    damaged.write_text(text.replace(old, new, 1))
    if not message:
        assert read_amc(path).n_frames == 5
        return
    with pytest.raises(UnusableMotion) as caught:
        read_amc(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_frames_and_no_file(bundled_body, capture, tmp_path):
    path = write_acclaim(tmp_path, bundled_body, capture)
    path.write_text(":DEGREES\n")
    with pytest.raises(UnusableMotion, match="a pose, not a motion: 0 frames"):
        read_amc(path)
    path.write_text("")
    with pytest.raises(UnusableMotion, match="empty"):
        read_amc(path)
