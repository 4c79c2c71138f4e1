# SPDX-License-Identifier: GPL-3.0-or-later
"""MVNX files: segments' poses come back as they stand, retargeted by their names; the wrong in a sentence."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import w2w
from w2w.core.body.body import JOINT_INDEX, N_JOINTS
from w2w.core.motion.motion import Motion, read_amass
from w2w.core.motion.skinning import joint_transforms, on_the_ground
from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.mvnx import CHAINS, read_mvnx
from w2w.core.retargeting.retarget import retarget

PLAYS = {
    "Pelvis": "pelvis", "L5": "spine1", "L3": "spine1", "T12": "spine2", "T8": "spine3", "Neck": "neck",
    "Head": "head",
    **{
        f"{side}{segment}": f"{side.lower()}_{joint}"
        for side in ("Left", "Right")
        for segment, joint in (
            ("Shoulder", "collar"), ("UpperArm", "shoulder"), ("ForeArm", "elbow"), ("Hand", "wrist"),
            ("UpperLeg", "hip"), ("LowerLeg", "knee"), ("Foot", "ankle"), ("Toe", "foot"),
        )
    },
}  # fmt: skip
ORDER = tuple(dict.fromkeys(segment for chain in CHAINS for segment in chain))


def frame_of(kind, rotations, positions):
    joints = [JOINT_INDEX[PLAYS[segment]] for segment in ORDER]
    quaternions = Rotation.from_matrix(rotations[joints]).as_quat()[:, [3, 0, 1, 2]]
    words = [" ".join(f"{x:.8f}" for x in values.ravel()) for values in (quaternions, positions[joints])]
    return (
        f'<frame type="{kind}"><orientation>{words[0]}</orientation><position>{words[1]}</position></frame>'
    )


def write_mvnx(path, body, motion):
    """A motion as MVN would export it, the T-pose first."""
    rotations, positions = joint_transforms(body, motion)
    still = Motion(np.tile(np.eye(3), (1, N_JOINTS, 1, 1)), body.joints[:1], 1.0)
    rest = joint_transforms(body, still)
    segments = "".join(f'<segment label="{name}" id="{k + 1}"/>' for k, name in enumerate(ORDER))
    frames = [frame_of("tpose", rest[0][0], rest[1][0])]
    frames += [frame_of("normal", *pose) for pose in zip(rotations, positions, strict=True)]
    path.write_text(
        '<?xml version="1.0"?><mvnx xmlns="http://www.xsens.com/mvn/mvnx" version="4">'
        f'<subject label="one" frameRate="{motion.rate:g}" segmentCount="{len(ORDER)}">'
        f"<segments>{segments}</segments><frames>{''.join(frames)}</frames></subject></mvnx>"
    )
    return path


@pytest.fixture(scope="module")
def capture(shared_data, bundled_body):
    """Half a second of real motion capture on the bundled body."""
    motion = on_the_ground(
        bundled_body, read_amass(shared_data / "smpl_poses/nghorbani__amass/amass_sample.npz")
    )
    return Motion(motion.rotations[:60], motion.pelvis[:60], 120.0)


def test_segments_come_back_and_move_the_body(bundled_body, capture, tmp_path):
    path = write_mvnx(tmp_path / "walk.mvnx", bundled_body, capture)
    source = read_mvnx(path)
    assert (source.rate, source.n_frames, source.people) == (120, 60, 1)
    rotations, positions = joint_transforms(bundled_body, capture)
    for segment, joint in PLAYS.items():
        found = source.matrices[:, source.bones.index(segment)]
        np.testing.assert_allclose(found[:, :3, 3], positions[:, JOINT_INDEX[joint]], atol=1e-6)
        np.testing.assert_allclose(found[:, :3, :3], rotations[:, JOINT_INDEX[joint]], atol=1e-6)
    carried = retarget(source, bundled_body)
    assert carried.bone_map == "Xsens MVN"
    again, _ = joint_transforms(bundled_body, carried.motion)
    for joint in ("pelvis", "left_shoulder", "left_elbow", "left_wrist", "right_hip", "right_knee", "head"):
        apart = rotations[:, JOINT_INDEX[joint]].swapaxes(1, 2) @ again[:, JOINT_INDEX[joint]]
        assert np.degrees(Rotation.from_matrix(apart).magnitude()).max() < 1, joint
    assert w2w.load(path)[0].n_frames == 60


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<?xml version="1.0"?>', '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "b">]>', "a document type"),
        ("</mvnx>", "", "it cannot be read as MVNX"),
        ('label="Pelvis"', 'label="Box"', "names no segments of MVN's"),
        ('frameRate="120"', 'frameRate="0"', "it says 0 frames a second"),
        ('frameRate="120"', 'frameRate="fast"', "it holds 'fast' where a number should be"),
        ('type="tpose"', 'type="other"', "it holds no calibration pose"),
        ("<position>", "<position>1 ", "its 23 segments need 92 and 69"),
        ("<orientation>", "<orientation>x", "where a number should be"),
        ('type="normal"', 'type="some"', ""),
    ],
)
def test_what_is_wrong_is_one_sentence(bundled_body, capture, tmp_path, old, new, message):
    short = Motion(capture.rotations[:5], capture.pelvis[:5], 120.0)
    path = write_mvnx(tmp_path / "a.mvnx", bundled_body, short)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    if not message:
        assert read_mvnx(path).n_frames == 4
        return
    with pytest.raises(UnusableMotion) as caught:
        read_mvnx(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_no_motion_and_other_bytes(bundled_body, capture, tmp_path):
    still = Motion(capture.rotations[:2], capture.pelvis[:2], 120.0)
    with pytest.raises(UnusableMotion, match="a pose, not a motion: 2 frames"):
        read_mvnx(write_mvnx(tmp_path / "a.mvnx", bundled_body, still))
    (tmp_path / "b.mvnx").write_bytes(b"\x00\xff" * 99)
    with pytest.raises(UnusableMotion, match="it cannot be read as MVNX"):
        read_mvnx(tmp_path / "b.mvnx")
