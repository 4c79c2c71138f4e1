# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint positions in files: every set and kind is known again, and what is wrong is one sentence."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import Y_UP_TO_Z_UP
from w2w.core.files import write_npz
from w2w.core.keypoints.facts import PoseFacts, is_joint_file, may_hold_joints
from w2w.core.keypoints.joint_sets import JOINT_SETS, JointSet, unseen
from w2w.core.keypoints.naming import plain_joint
from w2w.core.keypoints.pose_files import read_joints
from w2w.core.motion.motion import Motion, read_amass
from w2w.core.motion.skinning import on_the_ground
from w2w.core.motion.source import UnusableMotion
from w2w_studies.datasets.utd_mhad import read_utd_mhad

from ...rings import each_by_day
from ...seen_joints import seen_as

TOLD_BY_NAME = [name for name in JOINT_SETS if name not in ("mm-fit-17", "joint-centres")]


@pytest.fixture(scope="module")
def walk(shared_data, bundled_body):
    """Three seconds of real motion capture."""
    motion = on_the_ground(
        bundled_body, read_amass(shared_data / "smpl_poses/nghorbani__amass/amass_sample.npz")
    )
    step = round(motion.rate / 30)
    return Motion(motion.rotations[::step][:90], motion.pelvis[::step][:90], motion.rate / step)


def as_csv(path, joint_set, positions, rows=None, spell="{joint}_{axis}"):
    header = [spell.format(joint=joint, axis=axis) for joint in joint_set.joints for axis in "xyz"]
    lines = [",".join(f"{value:.6f}" for value in frame.ravel()) for frame in positions]
    path.write_text("\n".join([",".join(header), *(lines if rows is None else rows)]) + "\n")


def written(folder, kind, name, positions, rate):
    """The positions in millimetres, as a file of a kind."""
    path, joint_set = folder / f"clip.{kind}", JOINT_SETS[name]
    facts = {"rate": rate, "unit": "mm", "up": "z"}
    if kind == "csv":
        as_csv(path, joint_set, 1000 * positions)
    elif kind == "npy":
        np.save(path, 1000 * positions)
    elif kind == "npz":
        arrays = {"positions": 1000 * positions, "fps": np.array(rate), "unit": np.array("mm")}
        write_npz(path, arrays | {"up": np.array("z")})
        return path
    else:
        path.write_text(json.dumps({"positions": (1000 * positions).tolist(), **facts}))
        return path
    (folder / "clip.json").write_text(json.dumps(facts))
    return path


@pytest.mark.parametrize(
    ("joints", "landmarks", "wrong"),
    [
        ((), {"left knee": ()}, "left knee"),
        ((), {"head": ("skull",)}, "skull"),
        (("nose", "nose"), {}, "twice"),
    ],
)
def test_a_joint_set_that_lacks_something_is_refused(joints, landmarks, wrong):
    whole = JOINT_SETS["coco-17"]
    held = {**whole.landmarks, **landmarks}
    held = {landmark: members for landmark, members in held.items() if members}
    with pytest.raises(ValueError, match=wrong):
        JointSet("mine", (*whole.joints, *joints), held)


KINDS = ["csv", "npy", "npz", "json"]


@pytest.mark.parametrize(("name", "kind"), each_by_day(TOLD_BY_NAME, KINDS))
def test_every_set_is_known_again_in_every_kind_of_file(tmp_path, bundled_body, walk, name, kind):
    positions = seen_as(JOINT_SETS[name], bundled_body, walk)
    found = read_joints(written(tmp_path, kind, name, positions, walk.rate))
    assert found.joint_set == JOINT_SETS[name]
    assert (found.rate, found.unit, found.up, found.up_guessed) == (walk.rate, "mm", "z", "")
    np.testing.assert_allclose(found.positions, 1000 * positions, atol=1e-3)
    if kind == "npy":
        fit = found.fit(bundled_body)
        assert fit.scale == pytest.approx(0.001, rel=0.02)
        assert found.height(bundled_body, fit) == pytest.approx(bundled_body.height, rel=0.02)


def test_columns_in_any_order_and_spelling_with_a_clock_and_confidences(tmp_path, bundled_body, walk):
    joint_set = JOINT_SETS["openpose-25"]
    positions = seen_as(joint_set, bundled_body, walk)
    spelt = {"left": "L", "right": "R"}
    columns = [("time", np.arange(len(positions)) / 30)]
    for number in reversed(range(len(joint_set.joints))):
        side, _, part = joint_set.joints[number].partition("_")
        joint = (
            spelt[side] + part.title().replace("_", "") if side in spelt else joint_set.joints[number].title()
        )
        columns += [(f"{joint}.{axis.upper()}", positions[:, number, k]) for k, axis in enumerate("xyz")]
        columns.append((f"{joint}.confidence", np.ones(len(positions))))
    rows = np.stack([values for _, values in columns], axis=1)
    lines = [";".join(f"{value:.6f}".replace(".", ",") for value in row) for row in rows]
    (tmp_path / "a.csv").write_text(";".join(name for name, _ in columns) + "\n" + "\n".join(lines))
    found = read_joints(tmp_path / "a.csv", PoseFacts(unit="m"))
    assert found.joint_set == joint_set
    assert found.rate == pytest.approx(30)
    assert found.up_guessed == found.up
    assert found.up == "z"
    np.testing.assert_allclose(found.positions, positions, atol=1e-5)


@pytest.mark.parametrize(
    ("spelt", "plain"),
    [
        ("LeftHip", "left hip"), ("hip_l", "left hip"), ("LHip", "left hip"), ("RBigToe", "right bigtoe"),
        ("left_big_toe", "left bigtoe"), ("mouth_left", "left mouth"), ("SpineNavel", "spinenavel"),
        ("right hand tip", "right handtip"), ("nose", "nose"),
    ],
)  # fmt: skip
def test_a_joint_has_one_name_however_it_is_spelt(spelt, plain):
    assert plain_joint(spelt) == plain


def test_facts_on_the_command_line_come_before_the_file_and_the_file_before_its_side_car(tmp_path):
    positions = np.random.default_rng(0).normal(size=(10, 20, 3))
    write_npz(tmp_path / "a.npz", {"joints": positions, "fps": np.array(25.0)})
    (tmp_path / "a.json").write_text('{"rate": 50, "unit": "cm", "up": "y"}')
    found = read_joints(tmp_path / "a.npz")
    assert (found.rate, found.unit, found.up) == (25, "cm", "y")
    found = read_joints(tmp_path / "a.npz", PoseFacts(rate=100.0, up="-z"))
    assert (found.rate, found.unit, found.up) == (100, "cm", "-z")


def test_a_joint_at_nought_or_without_a_number_was_not_seen(tmp_path):
    positions = np.random.default_rng(0).normal(size=(10, 20, 3)) + 1
    positions[2, 5] = 0
    positions[3, 6, 1] = np.nan
    positions[:, 3] = 0  # the origin of the axes, in every frame
    np.save(tmp_path / "a.npy", positions)
    seen = np.isfinite(read_joints(tmp_path / "a.npy", PoseFacts(rate=30.0, up="y")).positions).all(axis=2)
    assert np.argwhere(~seen).tolist() == [[2, 5], [3, 6]]


def test_mmpose_and_flat_arrays_and_one_person_of_several_axes(tmp_path):
    positions = np.random.default_rng(0).normal(size=(6, 20, 3))
    frames = [
        {"frame_id": k, "instances": [{"keypoints": frame.tolist()}]} for k, frame in enumerate(positions)
    ]
    frames[3]["instances"] = []
    (tmp_path / "m.json").write_text(json.dumps({"meta_info": {}, "instance_info": frames}))
    given = PoseFacts(rate=30.0, up="y")
    found = read_joints(tmp_path / "m.json", given).positions
    assert np.isnan(found[3]).all()
    np.testing.assert_allclose(found[[0, 1, 2, 4, 5]], positions[[0, 1, 2, 4, 5]])
    for name, array in {
        "flat": positions.reshape(6, -1),
        "one": positions[:, None],
        "first": positions[None],
    }.items():
        np.save(tmp_path / f"{name}.npy", array)
        np.testing.assert_array_equal(read_joints(tmp_path / f"{name}.npy", given).positions, positions)


@pytest.mark.parametrize("kind", ["npy", "json"])
def test_of_several_people_one_is_chosen(tmp_path, kind):
    positions = np.random.default_rng(0).normal(size=(6, 3, 20, 3))
    positions[4:, 1] = positions[2:, 2] = np.nan
    path = tmp_path / f"a.{kind}"
    if kind == "npy":
        np.save(path, positions[:, ::-1])
    else:
        there = np.isfinite(positions).all(axis=(2, 3))
        info = [
            {"instances": [{"keypoints": person.tolist()} for person in frame[seen]]}
            for frame, seen in zip(positions, there, strict=True)
        ]
        path.write_text(json.dumps({"instance_info": info}))
    for person in (None, 1, 2):
        found = read_joints(path, PoseFacts(rate=4.0, up="y", person=person))
        np.testing.assert_allclose(found.positions, positions[:, (person or 1) - 1])
        assert found.people == 3
    with pytest.raises(UnusableMotion, match=r"it shows 3 people, and none is number 4 \(--person\)"):
        read_joints(path, PoseFacts(rate=4.0, person=4))


def test_seventeen_joints_that_make_no_body_must_be_named(tmp_path):
    np.save(tmp_path / "a.npy", np.random.default_rng(0).normal(size=(50, 17, 3)))
    with pytest.raises(UnusableMotion, match=r"may be human36m-17 or coco-17: say which"):
        read_joints(tmp_path / "a.npy", PoseFacts(rate=30.0))
    found = read_joints(tmp_path / "a.npy", PoseFacts(rate=30.0, joint_set="mm-fit-17", up="z"))
    assert found.joint_set == JOINT_SETS["mm-fit-17"]


@pytest.mark.parametrize("unseen_joints", [("wrist",), ("ankle",), ("elbow", "wrist")])
def test_joints_that_are_never_seen_make_no_other_set(tmp_path, walk, bundled_body, unseen_joints):
    joint_set = JOINT_SETS["coco-17"]
    positions = seen_as(joint_set, bundled_body, walk)
    for joint in unseen_joints:
        positions[:, [number for number, name in enumerate(joint_set.joints) if joint in name]] = np.nan
    np.save(tmp_path / "a.npy", positions)
    assert read_joints(tmp_path / "a.npy", PoseFacts(rate=30.0, up="z")).joint_set == joint_set


def pictured(positions, width, scores):
    """The first two of three coordinates in a picture `width` wide, and a score of each joint as third."""
    seen = positions[..., [0, 2]] / np.ptp(positions[..., [0, 2]], axis=(0, 1)).max()
    return np.concatenate([width * (seen - seen.min(axis=(0, 1))), scores[..., None]], axis=2)


@pytest.mark.parametrize("width", [1920, 1], ids=["pixels", "parts of the picture"])
@pytest.mark.parametrize("score", ["of the joint", "of the frame", "visibility", "none"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_score_is_no_third_dimension(tmp_path, bundled_body, walk, kind, width, score):
    rng, shape = np.random.default_rng(0), (walk.n_frames, 17)
    scores = {
        "of the joint": np.clip(rng.beta(8, 1.5, 17) + 0.02 * rng.normal(size=shape), 0, 1),
        "of the frame": rng.beta(8, 1.5, shape),
        "visibility": rng.integers(1, 2 if width == 1 else 3, shape),
        "none": np.zeros(shape),
    }[score]
    flat = pictured(seen_as(JOINT_SETS["coco-17"], bundled_body, walk), width, scores)
    path = written(tmp_path, kind, "coco-17", flat / 1000, walk.rate)
    for known in (PoseFacts(rate=30.0), PoseFacts(rate=30.0, joint_set="coco-17")):
        with pytest.raises(UnusableMotion, match=r"in the picture \(2D\) with a score or nothing as third"):
            read_joints(path, known)


@pytest.mark.parametrize("axes", [(0, 1, 2), (0, 2, 1), (1, 2, 0)], ids=str)
def test_a_body_that_stays_between_nought_and_one_is_one(tmp_path, bundled_body, walk, axes):
    positions = seen_as(JOINT_SETS["coco-17"], bundled_body, walk)[..., axes]
    positions = (positions - positions.min(axis=(0, 1))) / np.ptp(positions, axis=(0, 1)).max()
    np.save(tmp_path / "a.npy", positions + 0.002 * np.random.default_rng(0).random(positions.shape))
    facts = PoseFacts(rate=30.0, up="z")
    assert read_joints(tmp_path / "a.npy", facts).joint_set == JOINT_SETS["coco-17"]


def test_key_points_of_a_picture_and_joints_of_smpl_as_people_have_them(shared_cases):
    with pytest.raises(UnusableMotion, match=r"in the picture \(2D\)"):
        read_joints(shared_cases / "coco2d.npz")
    for name, joint_set in (("smpl24.npy", "smpl-24"), ("smplh52.npy", "smplh-52")):
        found = read_joints(shared_cases / name, PoseFacts(rate=30.0))
        assert found.joint_set == JOINT_SETS[joint_set]


def as_object(path, content):
    held = np.empty((), dtype=object)
    held[()] = content
    np.save(path, held, allow_pickle=True)


def test_a_result_of_motion_diffusion_is_read(tmp_path, bundled_body, walk, shared_cases):
    positions = seen_as(JOINT_SETS["humanml3d-22"], bundled_body, walk) @ Y_UP_TO_Z_UP
    motion = positions.transpose(1, 2, 0)[None].astype(np.float32)
    as_object(tmp_path / "results.npy", {"motion": motion, "text": ["x"], "lengths": np.array([80])})
    found = read_joints(tmp_path / "results.npy", PoseFacts(rate=20.0))
    assert (found.joint_set, found.up, found.up_guessed) == (JOINT_SETS["humanml3d-22"], "y", "")
    np.testing.assert_allclose(found.positions, positions[:80], atol=1e-6)
    as_object(tmp_path / "results.npy", {"motion": motion.repeat(3, axis=0)})
    with pytest.raises(
        UnusableMotion, match="it holds 3 motions, as motion diffusion writes them: save each"
    ):
        read_joints(tmp_path / "results.npy", PoseFacts(rate=20.0))
    assert read_joints(shared_cases / "mdm_results.npy", PoseFacts(rate=20.0)).n_frames == 170


def test_another_pickle_in_an_npy_is_named_and_runs_nothing(tmp_path):
    as_object(tmp_path / "a.npy", {"words": ["a"], "pose": 3})
    with pytest.raises(UnusableMotion, match=r"it holds a pickled object \(words, pose\), no array"):
        read_joints(tmp_path / "a.npy", PoseFacts(rate=20.0))
    as_object(tmp_path / "a.npy", {"motion": Path("x")})
    with pytest.raises(UnusableMotion, match=r"it names pathlib\S*: a model or motion holds arrays only"):
        read_joints(tmp_path / "a.npy", PoseFacts(rate=20.0))


RANDOM = np.random.default_rng(0).normal(size=(20, 20, 3))


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.npy", RANDOM[..., :2], "positions in the picture (2D)"),
        ("a.npy", RANDOM[:, :19], "it holds 19 joints, and no joint set has so many; there are human"),
        ("a.npy", RANDOM[:, None, None], "it has shape (20, 1, 1, 20, 3)"),
        ("a.npy", RANDOM[0, 0], "it has shape (3,)"),
        ("a.npy", np.zeros((5, 0, 3)), "it holds 0 joints"),
        ("a.npy", RANDOM[:2], "a pose, not a motion: 2 frames"),
        ("a.npy", np.full((9, 20, 3), np.nan), "never seen together: nobody is in it"),
        ("a.npy", RANDOM * 1e12, "beyond any unit of length"),
        ("a.npy", np.array(["x"] * 60).reshape(1, 20, 3), "its positions are no numbers"),
        ("a.npy", b"no npy", "a.npy is damaged or no npy file"),
        ("a.npy", b"", "the file is empty"),
        ("a.npz", {"other": RANDOM}, "it holds other, and none of positions"),
        ("a.npz", {"joints": RANDOM, "unit": np.array("furlong")}, "the pose's unit must be one of m, cm"),
        ("a.json", "{", "it cannot be read as JSON"),
        ("a.json", "[1, 2]", 'no JSON object with "positions"'),
        ("a.json", "[" * 100_000, "it cannot be read as JSON"),
        ("a.json", '{"positions": [[[1, 2, 3]], [[1, 2]]]}', "no regular list of frames"),
        ("a.json", '{"positions": [[["a", "b", "c"]]]}', "no regular list of frames"),
        ("a.json", '{"positions": ' + "[" * 600 + "]" * 600 + "}", "no regular list of frames"),
        ("a.json", '{"people": []}', "one frame of OpenPose"),
        ("a.json", '{"instance_info": [{"instances": []}]}', "shows nobody"),
        ("a.json", '{"positions": [[[1, 2, 3]]], "joint_names": ["a", "b"]}', "there are 2 'joint_names'"),
        ("a.json", '{"positions": [[[1, 2, 3]]], "rate": "fast"}', "the pose's rate must be a number"),
        ("a.json", '{"positions": [[[1, 2, 3]]], "rate": -1}', "the pose's rate must be frames a second"),
        ("a.csv", "file,activity\na,b\n", "its first line names no joints"),
        ("a.csv", "hip_x,hip_y,hip_z\n1,2\n", "its row 1 has 2 cells; the header has 3"),
        ("a.csv", "time,hip_x,hip_y,hip_z\n0,1,2,3\n0,1,2,3\n", "its column time does not rise"),
        ("a.csv", "time,hip_x,hip_y,hip_z\n0,1,2,3\n1,1,2,3\n9,1,2,3\n", "its frames are not regular"),
        ("a.csv", "hip_x,hip_y,hip_z\n" + "1,2,3\n" * 9, "(hip) are of no joint set or bone map"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_sentence(tmp_path, name, content, message):
    path = tmp_path / name
    if isinstance(content, np.ndarray):
        np.save(path, content)
    elif isinstance(content, dict):
        write_npz(path, content)
    else:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(UnusableMotion) as caught:
        read_joints(path, PoseFacts() if b"rate" in path.read_bytes()[-40:] else PoseFacts(rate=30.0))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_rate_unit_and_side_car_are_asked_for_in_a_sentence(tmp_path, bundled_body, walk):
    positions = seen_as(JOINT_SETS["kinect-20"], bundled_body, walk)
    np.save(tmp_path / "a.npy", positions)
    with pytest.raises(
        UnusableMotion, match=r"does not say its frame rate: give --pose-rate, .* a\.json next to it"
    ):
        read_joints(tmp_path / "a.npy")
    (tmp_path / "a.json").write_text("{")
    with pytest.raises(UnusableMotion, match=r"a\.json next to it cannot be read as JSON"):
        read_joints(tmp_path / "a.npy")
    (tmp_path / "a.json").write_text('{"rate": 30, "unit": "mm"}')
    with pytest.raises(
        UnusableMotion, match=r"in 'mm' its person would be 0\.00\d+ m tall: correct its unit"
    ):
        read_joints(tmp_path / "a.npy").fit(bundled_body)
    nowhere = positions.copy()
    nowhere[:, 4:] = np.nan
    np.save(tmp_path / "a.npy", nowhere)
    with pytest.raises(UnusableMotion, match="can hardly ever be seen: there is no body to fit"):
        read_joints(tmp_path / "a.npy", PoseFacts(up="z", unit="m")).fit(bundled_body)


def test_a_real_kinect_skeleton_is_read_and_fitted(shared_data, tmp_path, bundled_body):
    trial = read_utd_mhad(shared_data / "imu/utd_mhad/utd_mhad_subjects_1_4.npz")[0]
    np.save(tmp_path / "kinect.npy", trial.skeleton)
    found = read_joints(tmp_path / "kinect.npy", PoseFacts(rate=30.0, unit="m", up="y"))
    assert found.joint_set == JOINT_SETS["kinect-20"]
    fit = found.fit(bundled_body)
    assert 1.3 < found.height(bundled_body, fit) < 2.1
    assert fit.motion.n_frames == len(trial.skeleton)


def test_what_a_set_cannot_show_is_said():
    assert "turns of the forearms about their own axis" in unseen(JOINT_SETS["human36m-17"])
    assert "turns of the forearms about their own axis" not in unseen(JOINT_SETS["blazepose-33"])
    assert "the feet" in unseen(JOINT_SETS["coco-17"])
    assert "the feet" not in unseen(JOINT_SETS["openpose-25"])


def test_only_text_that_names_joints_is_taken_for_motion(tmp_path, bundled_body, walk):
    joint_set = JOINT_SETS["coco-17"]
    as_csv(tmp_path / "a.csv", joint_set, seen_as(joint_set, bundled_body, walk))
    (tmp_path / "labels.csv").write_text("file,activity\na.csv,walk\n")
    (tmp_path / "side.json").write_text('{"rate": 30, "unit": "m", "joint_set": "coco-17"}')
    (tmp_path / "bones.json").write_text('{"name": "x", "joints": {"pelvis": "hips"}}')
    (tmp_path / "b.json").write_text('{"rate": 30, "keypoints": []}')
    held = {path.name for path in tmp_path.iterdir() if may_hold_joints(path)}
    assert held == {"a.csv", "b.json"}
    write_npz(tmp_path / "amass.npz", {"poses": np.zeros((9, 72)), "joints": np.zeros((9, 22, 3))})
    assert not is_joint_file(tmp_path / "amass.npz")


def write_c3d(path, labels, positions, rate=100.0, unit="mm", screen=""):
    ezc3d = pytest.importorskip("ezc3d", exc_type=ImportError)
    made = ezc3d.c3d()
    made["parameters"]["POINT"]["RATE"]["value"] = [rate]
    made["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    made["parameters"]["POINT"]["LABELS"]["value"] = tuple(labels)
    made["data"]["points"] = np.concatenate(
        [positions.transpose(2, 1, 0), np.ones((1, positions.shape[1], len(positions)))]
    )
    if screen:
        made.add_parameter("POINT", "Y_SCREEN", [screen])
    made.write(str(path))


@pytest.mark.parametrize(
    "ends",
    [("HJC", "KJC", "AJC", "SJC", "EJC", "WJC"), ("FEP", "FEO", "TIO", "HUP", "HUO", "RAO")],
    ids=["joint centres", "plug-in gait"],
)
def test_joint_centres_of_a_c3d_file(tmp_path, bundled_body, walk, ends):
    joint_set = JOINT_SETS["coco-17"]
    positions = 1000 * seen_as(joint_set, bundled_body, walk)
    parts = ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
    columns = {
        f"Anna:{side[0].upper()}{end}": joint_set.joints.index(f"{side}_{part}")
        for side in ("left", "right")
        for part, end in zip(parts, ends, strict=True)
    }
    labels = ["Anna:LASI", *columns, "*12"]
    points = np.concatenate(
        [positions[:, :1], positions[:, list(columns.values())], positions[:, :1]], axis=1
    )
    write_c3d(tmp_path / "gait.c3d", labels, points)
    found = read_joints(tmp_path / "gait.c3d")
    assert (found.joint_set, found.rate, found.unit, found.up) == (
        JOINT_SETS["joint-centres"],
        100,
        "mm",
        "z",
    )
    fit = found.fit(bundled_body)
    assert found.height(bundled_body, fit) == pytest.approx(bundled_body.height, rel=0.02)
    write_c3d(tmp_path / "said.c3d", labels, points, screen="+Y")
    said = read_joints(tmp_path / "said.c3d")
    assert (said.up, said.up_guessed) == ("y", "")
    write_c3d(tmp_path / "markers.c3d", ["LASI", "RASI", "LHJC"], points[:, :3])
    with pytest.raises(
        UnusableMotion, match=r"no joint centre of the .*right hip.* holds LASI, RASI, LHJC: W2W"
    ):
        read_joints(tmp_path / "markers.c3d")


def test_c3d_files_that_are_none_or_cannot_be_read(tmp_path):
    (tmp_path / "a.c3d").write_bytes(b"x" * 600)
    with pytest.raises(UnusableMotion, match=r"it cannot be read as C3D|C3D files are read by ezc3d"):
        read_joints(tmp_path / "a.c3d")


@pytest.mark.parametrize(("first", "last", "bridged"), [(30, 45, True), (30, 46, False), (74, 90, False)])
def test_a_gap_without_hips_and_shoulders_is_bridged_up_to_half_a_second(
    tmp_path, walk, bundled_body, first, last, bridged
):
    positions = seen_as(JOINT_SETS["coco-17"], bundled_body, walk)
    positions[first:last] = np.nan
    path = written(tmp_path, "npz", "coco-17", positions, 30.0)
    if bridged:
        assert read_joints(path).n_frames == 90
        return
    said = (
        f"not seen from {first / 30:.2f} s to {last / 30:.2f} s; gaps are bridged up to 0.5 s: cut it there"
    )
    with pytest.raises(UnusableMotion, match=said):
        read_joints(path)


def test_humanml3d_features_are_the_joints_that_they_were_made_of(tmp_path, bundled_body, walk):
    """Features as HumanML3D's own code makes them: the root's turn, steps and height, then the joints."""
    joint_set = JOINT_SETS["humanml3d-22"]
    positions = seen_as(joint_set, bundled_body, walk) @ Y_UP_TO_Z_UP
    across = positions[:, 2] - positions[:, 1] + positions[:, 17] - positions[:, 16]  # right less left
    forward = np.cross([0, 1, 0], across)
    angle = np.arctan2(forward[:, 0], forward[:, 2])
    start = Rotation.from_rotvec([0, -angle[0], 0]).as_matrix()  # its clips begin at the origin, facing z
    truth = (positions - positions[0, 0] * [1, 0, 1]) @ start.T
    upright = Rotation.from_rotvec(-(angle - angle[0])[:, None] * [0, 1, 0]).as_matrix()
    features = np.zeros((len(truth), 263))
    features[:-1, 0] = -np.diff(np.unwrap(angle)) / 2
    steps = np.einsum("tij,tj->ti", upright[1:], np.diff(truth[:, 0], axis=0))
    features[:-1, 1:3], features[:, 3] = steps[:, [0, 2]], truth[:, 0, 1]
    local = truth[:, 1:] - truth[:, :1] * [1, 0, 1]
    features[:, 4:67] = np.einsum("tij,tkj->tki", upright, local).reshape(len(truth), -1)
    np.save(tmp_path / "new_joint_vecs.npy", features.astype(np.float32))
    found = read_joints(tmp_path / "new_joint_vecs.npy", PoseFacts(rate=20.0))
    assert (found.joint_set, found.up) == (joint_set, "y")
    assert np.abs(found.positions - truth).max() < 0.005


def test_kit_s_features_have_21_joints(tmp_path):
    features = np.random.default_rng(0).normal(size=(9, 251))
    np.save(tmp_path / "a.npy", features)
    found = read_joints(tmp_path / "a.npy", PoseFacts(rate=12.5, up="y"))
    assert (found.joint_set, found.n_frames) == (JOINT_SETS["kit-21"], 9)
    np.testing.assert_allclose(found.positions[0, 1:].ravel(), features[0, 4:64])


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("posed_joints", "soma-77"),
        ("posed_joints", "soma-30"),
        ("posed_joints", "humanml3d-22"),
        ("pred_joint_coords", "mhr-127"),
        ("pred_keypoints_3d", "mhr-70"),
    ],
)
def test_kimodo_and_sam_3d_body(tmp_path, bundled_body, walk, key, name):
    positions = seen_as(JOINT_SETS[name], bundled_body, walk)
    is_sam = key.startswith("pred")
    if is_sam:  # in the camera x is right, y down
        positions = np.stack([positions[..., 0], -positions[..., 2], positions[..., 1]], axis=2)
    else:
        positions = positions @ Y_UP_TO_Z_UP
    camera = np.cumsum(np.full((len(positions), 3), 0.01), axis=0)
    arrays = {key: positions, "global_rot_mats": np.zeros((2, 3, 3))}
    write_npz(tmp_path / "a.npz", arrays | ({"pred_cam_t": camera} if is_sam else {}))
    assert is_joint_file(tmp_path / "a.npz")
    found = read_joints(tmp_path / "a.npz", PoseFacts(rate=30.0))
    assert (found.joint_set, found.up) == (JOINT_SETS[name], "-y" if is_sam else "y")
    np.testing.assert_allclose(found.positions, positions + (camera[:, None] if is_sam else 0), atol=1e-9)


def test_a_robot_of_kimodo_is_no_body(tmp_path):
    write_npz(tmp_path / "a.npz", {"posed_joints": np.ones((9, 34, 3))})
    with pytest.raises(UnusableMotion, match="those of a robot"):
        read_joints(tmp_path / "a.npz", PoseFacts(rate=30.0))
