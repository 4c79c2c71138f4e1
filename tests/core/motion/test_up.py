# SPDX-License-Identifier: GPL-3.0-or-later
"""The axis that is up: by the format, the rest pose or a vote of the library; else it is asked for."""

import json
from collections import Counter
from itertools import product

import numpy as np
import pytest

import w2w
from w2w.core.body.body import JOINT_INDEX
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.keypoints.pose_files import JointPositions
from w2w.core.motion.motion import AMASS, SMPLX, Motion, read_amass
from w2w.core.motion.sight import LIMBS, TO_Z, UPS, Kind, Sight
from w2w.core.motion.source import SourceMotion, UnusableMotion
from w2w.core.motion.up import BY_ITSELF, Ups
from w2w.core.reading.clips import to_body
from w2w.core.reading.formats import read_beside, read_motion
from w2w.core.reading.look import look_up
from w2w.core.reading.reader import Reader

from ...exercises import exercises
from ...kinds_of_pose import MORE, RATE, TEN, UPRIGHT, joints_of, posed, trunk_of
from ...made_bvh import NAMES, write_bvh
from ...seen_joints import seen_as

HEADINGS = range(0, 360, 45)

FACTS = PoseFacts(rate=RATE)

TO_Z_UP = {"y": lambda p: np.stack([p[..., 0], -p[..., 2], p[..., 1]], axis=-1), "z": lambda p: p}
"""Points of a world whose y or z axis is up, in one with z up."""


def in_a_world(motion, up):
    """A motion in a world where another axis is up."""
    rotations = motion.rotations.copy()
    rotations[:, 0] = TO_Z[up].T @ rotations[:, 0]
    return Motion(rotations, motion.pelvis @ TO_Z[up], motion.rate)


def write_smpl(path, motion, names=("poses", "trans", "mocap_framerate"), up="z"):
    """A motion as an npz of SMPL poses whose axis `up` is up, without W2W's labels."""
    own = path.with_suffix(".own.npz")
    in_a_world(motion, up).save(own)
    with np.load(own) as data:
        poses, trans = data["poses"], data["trans"]
    own.unlink()
    if names[0] == "bodyPose":
        poses = poses[:, :66].reshape(-1, 22, 3)
    parts = {names[0]: poses}
    if names[0] == "global_orient":
        parts = {"global_orient": poses[:, :3], "body_pose": poses[:, 3:66]}
    with path.open("wb") as stream:
        np.savez(stream, **parts, **{names[1]: trans, names[2]: np.array(motion.rate)})


def write(path, kind, body, motion, up):
    """A motion as a file of a kind."""
    if kind in ("amass", "smplx", "smpl"):
        names = {"amass": ("poses", "trans"), "smplx": ("global_orient", "transl")}
        write_smpl(path, motion, (*names.get(kind, ("bodyPose", "bodyTranslation")), "frameRate"), up)
    elif kind.startswith("bvh"):
        write_bvh(path, body, motion, 3 if kind.endswith("rest") else None, t_pose=False, z_up=up == "z")
    else:
        np.save(path, seen_as(JOINT_SETS[kind], body, motion) @ TO_Z[up])


SUFFIXES = {"amass": ".npz", "smplx": ".npz", "smpl": ".smpl", "bvh": ".bvh", "bvh without rest": ".bvh"}


def trunk_read(source, body):
    """Median trunk, as `trunk_of` has it, of what was read from a file, z up."""
    if isinstance(source, Motion):
        return trunk_of(joints_of(body, source.rotations, source.pelvis))
    if isinstance(source, SourceMotion):
        heads = np.stack([source.matrices[:, source.bones.index(name), :3, 3] for name in NAMES], axis=1)
        return trunk_of(heads)
    assert isinstance(source, JointPositions)
    if source.up not in TO_Z_UP:
        return np.full(3, np.inf)
    places = TO_Z_UP[source.up](source.positions)
    parts = ("left_hip", "right_hip", "left_shoulder", "right_shoulder")
    whole = np.zeros((len(places), 24, 3))
    for part in parts:
        whole[:, JOINT_INDEX[part]] = places[:, source.joint_set.members(part.replace("_", " "))].mean(axis=1)
    return trunk_of(whole)


def outcome(path, body, motion, ups=BY_ITSELF):
    """Whether a file is read as the motion is ("right"), otherwise ("WRONG"), or not without a question."""
    try:
        source = read_motion(path, FACTS, ups)
    except UnusableMotion as error:
        if "give --pose-up" in str(error):
            return "asked"
        raise
    truth = trunk_of(joints_of(body, motion.rotations, motion.pelvis))
    return "right" if np.abs(trunk_read(source, body) - truth).max() < 0.1 else "WRONG"


def library(folder, kind, file_kind, body, up, standing, headings=HEADINGS, floor=0.0):
    """Files of a kind of motion, one a heading, and of people who stand; the motion of each."""
    folder.mkdir(parents=True, exist_ok=True)
    people = [posed(kind, body, heading, floor, "hips", heading) for heading in headings]
    for number in range(standing):
        stands = ("stand", "walk", "wave", "squat")[number % 4]
        people.append(posed(stands, body, 100 * number, floor, "hips", number))
    files = {}
    for number, motion in enumerate(people):
        path = folder / f"{number:02d}{SUFFIXES.get(file_kind, '.npy')}"
        write(path, file_kind, body, motion, up)
        files[path] = motion
    return files


def outcomes(files, body):
    """How the files of a library are read, or "asked" if the user is asked before."""
    seen = look_up(Reader(), [(path.name, path) for path in files], FACTS)
    if seen.question:
        return ["asked"]
    return [outcome(path, body, motion, seen.ups) for path, motion in files.items()]


FILES = [
    *((kind, up) for kind in ("amass", "smplx", "bvh without rest", "bvh", "humanml3d-22") for up in "yz"),
    ("coco-17", "y"),
    ("smpl-24", "z"),
    ("smpl", "y"),
]
TOLD = ("bvh", "smpl")
"""Kinds of files that say it, by a rest pose or their format."""

BY_FORMAT = (("amass", "z"), ("bvh without rest", "y"))
"""Kinds of files that are read by their format while nothing speaks against it."""

SURE = ("walk", "side_steps", "stairs", "squat", "wheelchair_far")
"""Kinds of motion that nobody makes who lies."""


def check_alone(folder, body, file_kind, up, kinds):
    for kind in kinds:
        ends = Counter()
        for heading in HEADINGS:
            motion = posed(kind, body, heading, seed=heading)
            path = folder / f"a{SUFFIXES.get(file_kind, '.npy')}"
            write(path, file_kind, body, motion, up)
            ends[outcome(path, body, motion)] += 1
        assert not ends["WRONG"], kind
        assert ends["right"] == 8 or not (file_kind in TOLD or kind in SURE), kind
        assert ends["right"] >= 6 or kind not in UPRIGHT, kind


@pytest.mark.parametrize(("file_kind", "up"), [FILES[0], FILES[3], FILES[8], FILES[12]])
def test_a_file_alone_is_read_right_or_asked_for(tmp_path, bundled_body, file_kind, up):
    check_alone(tmp_path, bundled_body, file_kind, up, ["supine", "stand", "walk"])


@pytest.mark.parametrize(("file_kind", "up"), BY_FORMAT)
def test_what_a_format_alone_says_of_who_does_not_stand_is_said(tmp_path, bundled_body, file_kind, up):
    for kind, assumed in (("supine", True), ("crawl", True), ("walk", False)):
        file = tmp_path / f"{kind}{SUFFIXES.get(file_kind, '.npy')}"
        write(file, file_kind, bundled_body, posed(kind, bundled_body, 45), up)
        found = to_body(read_motion(file, FACTS), bundled_body)
        assert found.facts().get("up_guessed") == (up if assumed else None), kind
        said = look_up(Reader(), [(file.name, file)]).sentence()
        assert said.endswith(", as is usual") == assumed, kind
    stands = library(tmp_path / "library", "supine", file_kind, bundled_body, up, 8, [90])
    seen = look_up(Reader(), [(path.name, path) for path in stands])
    assert not seen.sentence().endswith("usual")
    assert not read_motion(next(iter(stands)), FACTS, seen.ups).up_guessed


@pytest.mark.slow
@pytest.mark.parametrize(("file_kind", "up"), FILES)
def test_all_kinds_of_motion_alone_are_read_right_or_asked_for(tmp_path, bundled_body, file_kind, up):
    check_alone(tmp_path, bundled_body, file_kind, up, [*TEN, *MORE])


PLACES = [
    *((floor, start) for floor in (-1.05, 0.0, 0.3, 0.45, 0.9) for start in ("hips", "feet", "away")),
    (None, "hips"),
]
KINDS = (AMASS, SMPLX, Kind("BVH", "y", firm=True), Kind("joints", "y", read=UPS))


@pytest.mark.slow
@pytest.mark.parametrize("kind", [*TEN, *MORE])
def test_no_floor_lays_down_who_stands_or_stands_up_who_lies(bundled_body, kind):
    """By itself a clip is right or asked for, and as one of many it never votes for a wrong axis.

    Of who lies or sits in a file that breaks its format's convention only if the ground is at 0, else what is
    read is said to be assumed.
    """
    for (floor, start), up, heading in product(PLACES, "yz", HEADINGS):
        motion = posed(kind, bundled_body, heading, floor, start, heading)
        joints = joints_of(bundled_body, motion.rotations, motion.pelvis) @ TO_Z[up]
        both = {part: [JOINT_INDEX[f"{side}_{part}"] for side in ("left", "right")] for part in LIMBS}
        seen = Sight.of(joints, {part: joints[:, columns] for part, columns in both.items()})
        for files in KINDS:
            case = (files.name, up, floor, start, heading)
            by_format = files.firm and up != files.usual and floor != 0 and kind not in UPRIGHT
            wrong = {*files.read} - {up} - {files.usual if by_format else up}
            found = seen.by_itself(files)
            assert found not in wrong, case
            assert found in (up, None) or BY_ITSELF.guess(files, seen, found) == found, case
            assert set(seen.votes(files)) <= {up}, case
            if kind in SURE and floor is not None:
                assert seen.by_itself(files) == up, case


@pytest.mark.parametrize(("file_kind", "up"), [("amass", "y"), ("smplx", "z"), ("smpl-24", "z")])
def test_one_clip_decides_for_no_library_and_several_do(tmp_path, bundled_body, file_kind, up):
    for kind in ("supine", "handstand"):
        for standing, expected in ((1, {"asked"}), (3, {"right"})):
            files = library(
                tmp_path / f"{kind}{standing}", kind, file_kind, bundled_body, up, standing, [180]
            )
            assert set(outcomes(files, bundled_body)) == expected, (kind, standing)


@pytest.mark.parametrize(
    ("kinds", "up", "floor", "expected"),
    [
        (("stand", "walk", "supine"), "z", 0.0, "z"),
        (("walk", "squat", "supine", "supine"), "z", 0.9, "z"),
        (("stand", "wave", "one_leg"), "y", -1.05, "y"),  # nobody moves
        (("stand", "wave", "one_leg"), "y", None, "y"),  # all in place
        (("stand", "wave"), "y", -1.05, None),
        (("supine", "prone", "walk"), "y", 0.0, None),
    ],
)
def test_a_format_holds_while_nothing_speaks_against_it(tmp_path, bundled_body, kinds, up, floor, expected):
    for number, kind in enumerate(kinds):
        motion = posed(kind, bundled_body, 90 * number, floor, "away", number)
        write_smpl(tmp_path / f"{number}.npz", motion, up=up)
    seen = look_up(Reader(), [(path.name, path) for path in sorted(tmp_path.iterdir())])
    assert (seen.ups.chosen, bool(seen.question)) == ((("AMASS", expected),), expected is None)


@pytest.mark.slow
@pytest.mark.parametrize(("file_kind", "up"), FILES[:12])
def test_libraries_are_read_right_or_asked_for(tmp_path, bundled_body, file_kind, up):
    """Eight headings, or one bed for all, with 0, 1, 3 and 8 people who stand."""
    alike = {"eight": HEADINGS, "one": [180], "same": [180] * 8}
    for kind, standing, (name, headings) in product(TEN, (0, 1, 3, 8), alike.items()):
        folder = tmp_path / f"{kind} {standing} {name}"
        ends = outcomes(library(folder, kind, file_kind, bundled_body, up, standing, headings), bundled_body)
        assert "WRONG" not in ends, folder.name
        if file_kind in TOLD or (standing >= 3 and len(headings) <= standing):
            assert set(ends) == {"right"}, folder.name
        elif not standing and kind not in ("stand", "wheelchair"):
            assert ends == ["asked"] or (file_kind, up) in BY_FORMAT, folder.name


def test_what_speaks_for_each_axis_is_asked_with(tmp_path, bundled_body):
    files = library(tmp_path, "supine", "smplx", bundled_body, "y", 2, [0, 45, 180])
    seen = look_up(Reader(), [(path.name, path) for path in files], FACTS)
    said = (
        "nothing says which axis is up in 5 files of SMPL-X; people may stand along y in 2, -z in 1, z in 1, "
    )
    assert seen.question == f"{said}none in 1: give --pose-up, or Up in Blender's import dialog"
    assert seen.sentence() == "not known, 5 files of SMPL-X"
    with pytest.raises(ValueError, match=r"none in 1: give pose=PoseFacts\(up=\.\.\.\)$"):
        w2w.load(tmp_path)
    motions = w2w.load(tmp_path, pose=PoseFacts(up="y"))
    upright = [trunk_read(motion, bundled_body)[0, 2] > 0.9 for motion in motions]
    assert upright == [False, False, False, True, True]
    assert not look_up(Reader(), [(path.name, path) for path in files], PoseFacts(up="y")).question


def test_few_files_that_are_asked_for_do_not_stop_others(tmp_path, bundled_body):
    files = library(tmp_path / "a", "supine", "bvh", bundled_body, "y", 0)
    files |= library(tmp_path / "b", "supine", "humanml3d-22", bundled_body, "z", 0, [90])
    named = [(path.relative_to(tmp_path).as_posix(), path) for path in files]
    seen = look_up(Reader(), named, FACTS)
    assert not seen.question
    joints = JOINT_SETS["humanml3d-22"]
    assert seen.sentence() == f"y, 8 files of BVH; not known, 1 file of joints ({joints.name})"
    ends = [outcome(path, bundled_body, motion, seen.ups) for path, motion in files.items()]
    assert ends == [*["right"] * 8, "asked"]


def test_a_bvh_file_without_a_rest_pose_follows_its_skeleton_s_files(tmp_path, bundled_body):
    """Not those of other skeletons, while its own decide."""
    files = library(tmp_path / "z", "supine", "bvh without rest", bundled_body, "z", 3, [90])
    others = library(tmp_path / "y", "supine", "bvh without rest", bundled_body, "y", 4, [90])
    for path in others:
        text = path.read_text()
        for name in NAMES:
            text = text.replace(f" {name}\n", f" {name}_\n") if name.startswith("LeftHandM") else text
        path.write_text(text)
    seen = look_up(Reader(), [(str(path), path) for path in [*files, *others]], FACTS)
    assert {outcome(path, bundled_body, motion, seen.ups) for path, motion in files.items()} == {"right"}
    assert {read_motion(path, FACTS, seen.ups).up for path in others} == {"y"}
    assert {read_motion(path, FACTS, seen.ups).up_guessed for path in files} == {"z"}


def test_people_who_walk_speak_against_a_rest_pose_and_who_lie_do_not(tmp_path, bundled_body):
    walks, lies = (posed(kind, bundled_body, 0, 0.0, "feet") for kind in ("walk", "prone"))
    write_bvh(tmp_path / "walks.bvh", bundled_body, walks, folded_by=0, t_pose=False)  # offsets are z up
    write_bvh(tmp_path / "lies.bvh", bundled_body, lies, t_pose=False)
    assert (read_motion(tmp_path / "walks.bvh").up, read_motion(tmp_path / "walks.bvh").up_guessed) == (
        "y",
        "y",
    )
    assert (read_motion(tmp_path / "lies.bvh").up, read_motion(tmp_path / "lies.bvh").up_guessed) == ("y", "")
    assert outcome(tmp_path / "lies.bvh", bundled_body, lies) == "right"


def test_a_leading_t_pose_is_a_rest_pose(tmp_path, bundled_body):
    lies = posed("supine", bundled_body, 90)
    write_bvh(tmp_path / "a.bvh", bundled_body, lies, folded_by=3, z_up=True)
    assert outcome(tmp_path / "a.bvh", bundled_body, lies) == "right"


@pytest.mark.parametrize("up", UPS)
def test_all_six_axes_can_be_given_for_poses_and_joints(tmp_path, bundled_body, up):
    motion, joints = posed("supine", bundled_body, 30), JOINT_SETS["humanml3d-22"]
    write_smpl(tmp_path / "a.npz", motion, up=up)
    pose = PoseFacts(rate=motion.rate, up=up)
    found = read_motion(tmp_path / "a.npz", pose)
    assert found.up_guessed == ""
    np.testing.assert_allclose(found.pelvis, motion.pelvis, atol=1e-5)
    np.save(tmp_path / "a.npy", seen_as(joints, bundled_body, motion) @ TO_Z[up])
    source = read_motion(tmp_path / "a.npy", pose)
    expected = seen_as(joints, bundled_body, motion)
    np.testing.assert_allclose(source.positions @ TO_Z[source.up].T, expected, atol=1e-9)


def test_a_side_car_says_what_is_up_in_poses(tmp_path, bundled_body):
    motion = posed("stand", bundled_body, 30)
    write_smpl(tmp_path / "a.npz", motion, up="-y")
    for content, said in (
        ('["another program\'s"]', None),
        ('{"Up": "w"}', "a.json next to it: the pose's up must"),
    ):
        (tmp_path / "a.json").write_text(content)
        with pytest.raises(UnusableMotion, match=said or "does not say which axis is up"):
            read_motion(tmp_path / "a.npz")
    (tmp_path / "a.json").write_text(json.dumps({"up_axis": "-Y", "rate": "fast"}))
    np.testing.assert_allclose(read_motion(tmp_path / "a.npz").pelvis, motion.pelvis, atol=1e-5)
    assert not look_up(Reader(), [("a.npz", tmp_path / "a.npz")]).question
    assert read_beside(tmp_path / "a.npz") == [tmp_path / "a.json"]


@pytest.mark.slow
@pytest.mark.parametrize("up", "yz")
def test_people_who_exercise_are_read_whatever_is_up(tmp_path, up):
    """In one library; those of every kind of file alone are right or asked for."""
    motions = [*exercises(3).values()]
    for number, motion in enumerate(motions):
        write_smpl(tmp_path / f"{number}.npz", motion, up=up)
    seen = look_up(Reader(), [(path.name, path) for path in sorted(tmp_path.iterdir())])
    assert seen.ups.chosen == (("AMASS", up),)
    how = "" if up == "z" else ", as people stand"
    assert seen.sentence() == f"{up}, {len(motions)} files of AMASS{how}"
    for number, motion in enumerate(motions):
        found = read_motion(tmp_path / f"{number}.npz", ups=seen.ups)
        assert found.up_guessed == ("" if up == "z" else "y")
        np.testing.assert_allclose(found.pelvis, motion.pelvis, atol=1e-5)


def test_what_is_assumed_is_a_fact_of_the_clip(tmp_path, bundled_body):
    write_smpl(tmp_path / "a.npz", posed("walk", bundled_body), up="y")
    facts = to_body(read_motion(tmp_path / "a.npz"), bundled_body).facts()
    assert facts["up_guessed"] == "y"
    write_smpl(tmp_path / "a.npz", posed("walk", bundled_body), up="z")
    assert "up_guessed" not in to_body(read_motion(tmp_path / "a.npz"), bundled_body).facts()


def test_a_camera_s_axes_are_asked_for(tmp_path, bundled_body):
    far = posed("walk", bundled_body, 30, 0.3, "away")
    write_smpl(tmp_path / "a.npz", far, ("global_orient", "transl", "fps"), "-y")
    with pytest.raises(UnusableMotion, match="stand along -y: give --pose-up"):
        read_amass(tmp_path / "a.npz")
    np.testing.assert_allclose(read_amass(tmp_path / "a.npz", up="-y").pelvis, far.pelvis, atol=1e-5)


def test_a_file_head_down_is_asked_for_alone_and_a_motion_among_others(tmp_path, bundled_body):
    for name, kind in {
        "handstand": "handstand",
        "walk": "walk",
        "stairs": "stairs",
        "squat": "squat",
    }.items():
        (tmp_path / name).mkdir()
        write_smpl(tmp_path / name / "a.npz", posed(kind, bundled_body, 60))
    alone = tmp_path / "handstand" / "a.npz"
    with pytest.raises(ValueError, match=r"may stand along -z: give pose=PoseFacts\(up"):
        w2w.load(alone)
    assert w2w.load(alone, pose=PoseFacts(up="z"))[0].head_down
    turned = w2w.load(alone, pose=PoseFacts(up="-z"))[0]
    assert turned.rotations[:, 0, 2, 2].mean() > 0.9
    assert [motion.head_down for motion in w2w.load(tmp_path)] == [True, False, False, False]
    write_bvh(alone.with_suffix(".bvh"), bundled_body, posed("handstand", bundled_body), t_pose=False)
    with pytest.raises(ValueError, match="trunks point down in most of the frames: give pose=PoseFacts"):
        w2w.load(alone.with_suffix(".bvh"))


CASES = [
    ("lying_zup.npz", (0.1, 0.6), (0.0, 0.35)),
    ("lying_yup.smpl", (0.1, 0.6), (0.0, 0.35)),
    ("crawl_facing0.npz", (0.04, 0.25), (0.0, 1.0)),
    ("crawl_facing90.npz", (0.04, 0.25), (0.0, 1.0)),
    ("supine_facing270.npz", (0.03, 0.25), (0.0, 1.0)),
    ("second/prone_no_rest_pose.bvh", (-0.1, 0.1), (0.0, 1.0)),
    ("blender_export_jog.bvh", (0.9, 1.0), (0.8, 1.1)),
    ("blender_export_lie_down.bvh", (0.3, 0.9), (0.1, 0.5)),
    ("second/squat_yup_floor_30cm.npz", (0.9, 1.0), (0.4, 1.0)),
    ("second/prone_feet_at_origin.bvh", (-0.1, 0.1), (-1.0, 1.0)),
    ("second/on_a_bench_feet_at_origin.bvh", (-0.1, 0.1), (-1.0, 1.0)),
]


@pytest.mark.parametrize(("file", "trunk_z", "pelvis"), CASES, ids=[case[0] for case in CASES])
def test_files_that_were_turned_wrongly_once(shared_cases, bundled_body, file, trunk_z, pelvis):
    found = to_body(read_motion(shared_cases / file), bundled_body).motion
    assert trunk_z[0] <= trunk_read(found, bundled_body)[0, 2] <= trunk_z[1]
    assert pelvis[0] <= np.median(found.pelvis[:, 2]) <= pelvis[1]


def test_a_library_over_a_low_ground_stands(shared_cases, bundled_body):
    found = w2w.load(shared_cases / "second/yup_low_ground")
    assert len(found) == 6
    assert min(trunk_read(motion, bundled_body)[0, 2] for motion in found) > 0.97


@pytest.mark.parametrize(
    ("file", "up", "trunk_z"),
    [
        ("gvhmr_incam.npz", "-y", (0.5, 1.0)),
        ("upside_down.bvh", "-y", (0.5, 1.0)),
    ],
)
def test_files_whose_axis_must_be_given(shared_cases, bundled_body, file, up, trunk_z):
    with pytest.raises(ValueError, match="give pose=PoseFacts"):
        w2w.load(shared_cases / file)
    found = w2w.load(shared_cases / file, pose=PoseFacts(up=up))[0]
    assert trunk_z[0] <= trunk_read(found, bundled_body)[0, 2] <= trunk_z[1]


def test_a_file_whose_skeleton_has_an_axis_is_not_looked_at():
    def never():
        raise AssertionError("it was looked at")

    ups = Ups((("BVH 1", "z"), ("SMPL-X", "y"), ("AMASS", None)))
    assert ups.with_guess(Kind("BVH", "y", firm=True, skeleton="1"), never) == ("z", "z")
    assert ups.with_guess(Kind("BVH", "z", firm=True, skeleton="1"), never) == ("z", "")
    assert ups.with_guess(SMPLX, never) == ("y", "y")
    with pytest.raises(AssertionError):
        ups.with_guess(AMASS, never)
