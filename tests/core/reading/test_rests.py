# SPDX-License-Identifier: GPL-3.0-or-later
"""One guess of a rest pose for all clips of a skeleton whose files have none."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import w2w
from w2w.core.body.body import JOINT_INDEX, Body
from w2w.core.body.shapes import shaped
from w2w.core.library.library import Clip
from w2w.core.motion.skinning import joint_transforms
from w2w.core.readers.bvh import read_bvh
from w2w.core.reading.clips import ALONE, ITS_OWN, to_body
from w2w.core.reading.look import lacking_rests, look_rests
from w2w.core.reading.reader import Reader
from w2w.core.study.config import StudyConfig
from w2w.headless.runs.clip_task import ClipTask, Engine

from ...exercises import exercises
from ...made_bvh import NAMES, write_bvh

LIMBS = [
    JOINT_INDEX[f"{side}_{part}"]
    for side in ("left", "right")
    for part in ("hip", "knee", "ankle", "shoulder", "elbow")
]
"""Joints whose turns positions show; a hand's are unknown."""


@pytest.fixture(scope="module")
def recorded(bundled_body, tmp_path_factory):
    """Clips of three performers: two whose bones are turned so that offsets are no rest pose, one T-posed."""
    folder = tmp_path_factory.mktemp("recorded")
    motions = list(exercises(2).values())[:6]
    for number, motion in enumerate(motions):
        write_bvh(folder / f"ann_{number}.bvh", bundled_body, motion, folded_by=3, t_pose=False)
        write_bvh(folder / f"bo_{number}.bvh", bundled_body, motion, folded_by=4, t_pose=number == 4)
        write_bvh(folder / f"cy_{number}.bvh", bundled_body, motion, t_pose=False)
    return folder, motions


def files_of(folder, of=""):
    return [(path.name, path) for path in sorted(folder.glob(f"{of}*.bvh"))]


def rests_of(files, body=None):
    return look_rests(Reader(), lacking_rests(files), body or Body.bundled())


def turned(body, motion):
    return joint_transforms(body, motion)[0]


def degrees(a, b):
    turns = a.swapaxes(-1, -2) @ b
    return np.degrees(Rotation.from_matrix(turns.reshape(-1, 3, 3)).magnitude()).reshape(turns.shape[:-2])


def test_each_skeleton_without_a_rest_pose_gets_one_whatever_the_order(recorded):
    folder, _ = recorded
    rests = rests_of(files_of(folder))
    assert set(rests.files) == {path.name for path in folder.iterdir() if path.name[:2] in ("an", "bo")}
    assert len(rests.poses) == 2
    assert rests_of(files_of(folder)[::-1]) == rests
    assert rests.of_file("ann_0.bvh").poses == rests_of(files_of(folder, "ann")).poses
    assert rests.sentence() == "one guess for each of 2 skeletons without one, in 12 files"
    assert rests_of(files_of(folder, "ann_0")) == ALONE


def test_all_clips_of_a_skeleton_move_by_the_same_rest_pose_near_the_true_one(recorded, bundled_body):
    folder, motions = recorded
    rests = rests_of(files_of(folder))
    for number, motion in enumerate(motions):
        source = read_bvh(folder / f"ann_{number}.bvh")
        assert not source.rest_is_known
        found = to_body(source, bundled_body, rests=rests)
        assert found.rest_guessed == "from 6 clips of it"
        off = degrees(turned(bundled_body, found.motion), turned(bundled_body, motion))
        assert np.median(off, axis=0)[LIMBS].max() < 20
    assert to_body(source, bundled_body).rest_guessed == ITS_OWN
    assert to_body(read_bvh(folder / "cy_0.bvh"), bundled_body, rests=rests).rest_guessed == ""


def test_a_guess_has_the_bones_of_the_body_that_is_asked_about(recorded, bundled_body):
    folder, _ = recorded
    joints = [JOINT_INDEX[f"left_{part}"] for part in ("hip", "knee", "shoulder", "elbow", "wrist")]
    names = read_bvh(folder / "ann_0.bvh").bones
    bones = [names.index(NAMES[joint]) for joint in joints]
    for body in (bundled_body, shaped(bundled_body, height=1.95, weight=60.0)):
        ((_, pose, _),) = rests_of(files_of(folder, "ann"), body).poses
        places = np.frombuffer(pose).reshape(len(names), 4, 4)[bones][:, :3, 3]
        found, own = (np.linalg.norm(np.diff(at, axis=0), axis=1) for at in (places, body.joints[joints]))
        np.testing.assert_allclose(found / found[0], own / own[0], atol=1e-6)


def test_a_rest_pose_that_leads_one_clip_is_that_of_all(recorded, bundled_body):
    folder, motions = recorded
    found = to_body(read_bvh(folder / "bo_0.bvh"), bundled_body, rests=rests_of(files_of(folder)))
    assert found.rest_guessed == "that leads one of its clips"
    off = degrees(turned(bundled_body, found.motion), turned(bundled_body, motions[0]))
    assert np.median(off, axis=0).max() < 1


def test_a_clip_is_made_anew_only_with_another_guess_for_its_own_skeleton(recorded, tmp_path):
    folder, _ = recorded
    all_files = files_of(folder)

    def key(files, name):
        clip = Clip(folder / name, name, name, "walk")
        rests = rests_of(files)
        of_all, its = (
            ClipTask(clip, tmp_path, StudyConfig(), "inputs", Engine(rests=each)).key("0")
            for each in (rests, rests.of_file(name))
        )
        assert of_all == its  # workers get no more than that of their clip
        return its

    fewer = [file for file in all_files if file[0] != "bo_5.bvh"]
    assert key(all_files, "ann_0.bvh") == key(fewer, "ann_0.bvh") == key(files_of(folder, "ann"), "ann_0.bvh")
    assert key(all_files, "ann_0.bvh") != key(files_of(folder, "ann")[:4], "ann_0.bvh")
    assert key(all_files, "cy_0.bvh") == key(fewer, "cy_0.bvh") == key([], "cy_0.bvh")


def test_recordings_of_one_skeleton_differ_as_their_truth_does(shared_cases, bundled_body):
    """Forearms turned by 70 degrees came out alike when each file had a guess of its own."""
    names = [f"palms_{way}" for way in ("down", "up")]
    files = [(f"{name}.bvh", shared_cases / "second" / f"{name}.bvh") for name in names]
    rests = rests_of(files)
    apart = []
    for truth in ("", "_truth"):
        both = [
            to_body(read_bvh(path.with_stem(path.stem + truth)), bundled_body, rests=rests).motion
            for _, path in files
        ]
        apart.append(np.median(degrees(*(turned(bundled_body, motion) for motion in both)), axis=0))
    elbows = [JOINT_INDEX[f"{side}_elbow"] for side in ("left", "right")]
    assert np.abs(apart[0] - apart[1]).max() < 3
    assert (apart[1][elbows] > 65).all()


def test_python_says_which_rest_poses_are_guesses(recorded):
    folder, _ = recorded
    said = {about["file"]: about.get("rest_guessed", "") for about in w2w.load(folder).facts}
    assert said["ann_0.bvh"] == "from 6 clips of it"
    assert said["bo_0.bvh"] == "that leads one of its clips"
    assert said["bo_4.bvh"] == said["cy_0.bvh"] == ""
