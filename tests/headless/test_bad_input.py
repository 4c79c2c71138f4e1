# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever lies in a library: a true sentence and an exit code, never a traceback, and the rest goes on."""

import csv
import json
import os
import shutil

import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.core.files import write_npz
from w2w.headless.app import APP

from ..clip_lists import skipped_clips
from ..command_line import cli
from ..made_bvh import ONE_JOINT
from ..real_clips import FOUR, in_folders

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")

BVH = (
    ONE_JOINT
    + """MOTION
Frames: %d
Frame Time: %s
%s"""
)


def run(library, out, *options):
    return cli("run", library, "--out", out, "--patches", 8, "--no-pictures", "--workers", 1, *options)


@pytest.fixture
def library(shared_data, tmp_path):
    """Four good clips, in folders that label them."""
    return in_folders(shared_data, tmp_path / "library")


def amass(path, frames=90, **changed):
    rng = np.random.default_rng(0)
    arrays = {
        "poses": (0.1 * rng.normal(size=(frames, 72))).cumsum(axis=0) * 0.1,
        "trans": np.zeros((frames, 3)),
        "mocap_framerate": np.array(30.0),
    }
    write_npz(path, arrays | changed, compress=True)


@pytest.mark.slow
def test_everything_bad_at_once_costs_only_itself(shared_data, library, tmp_path):
    with (shared_data / "motions.csv").open(newline="", encoding="utf-8") as stream:
        negatives = [row["file"] for row in csv.DictReader(stream) if row["activity"] == "negative"]
    poses = [path for path in (shared_data / "smpl_poses").rglob("*.*") if path.suffix in (".npz", ".smpl")]
    bad = library / "walking" / "bad"
    bad.mkdir()
    for file in (*(shared_data / name for name in negatives), *poses):
        shutil.copy(file, bad)
    expected = dict.fromkeys(
        (
            "truncated_50pct_Walking.fbx", "truncated_header_only.fbx", "zero_bytes.fbx",
            "lfs_pointer_Feminine_TPose.fbx", "static_mesh_box_001.fbx", "kick.bvh", "0000.npz",
            "apose_to_handsFront_smplx.npz", "pose_avatar.smpl", "body_pose_rnd.npz",
        ),
        "",
    )  # fmt: skip
    nan = np.zeros((90, 72))
    nan[7, 3] = np.nan
    amass(bad / "nan.npz", poses=nan)
    amass(bad / "infinite.npz", trans=np.full((90, 3), np.inf))
    amass(bad / "one frame.npz", frames=1)
    amass(bad / "no frames.npz", frames=0)
    amass(bad / "moment.npz", frames=8)
    amass(bad / "no rate.npz", mocap_framerate=np.array(np.nan))
    amass(
        bad / "ten hours.npz", poses=np.zeros((10 * 3600 * 30, 72), np.float32), trans=np.zeros((1080000, 3))
    )
    np.savez(bad / "pickled.npz", poses=np.array([{"a": 1}], dtype=object))
    (bad / "text.npz").write_text("no zip")
    (bad / "one bone.bvh").write_text(BVH % (60, 0.03, "\n".join(f"0 0 0 {n} 0 0" for n in range(60))))
    (bad / "no frames.bvh").write_text(BVH % (0, 0.03, ""))
    (bad / "endless.bvh").write_text(BVH % (10**9, 0.03, "0 0 0 0 0 0"))
    (bad / "gone.fbx").symlink_to(tmp_path / "nowhere.fbx")
    (bad / "folder.fbx").mkdir()
    os.mkfifo(bad / "pipe.fbx")
    shutil.copy(library / "running" / "Run.fbx", bad / "renamed.bvh")
    expected |= {
        "nan.npz": "not finite",
        "infinite.npz": "not finite",
        "one frame.npz": "a pose, not a motion: 1 frame",
        "no frames.npz": "a pose, not a motion: 0 frames",
        "moment.npz": "shorter than the 0.5 s a window needs",
        "no rate.npz": "does not say its frame rate",
        "ten hours.npz": "too long to be read at once",
        "pickled.npz": "",
        "text.npz": "cannot be read as an npz file",
        "one bone.bvh": "",
        "no frames.bvh": "",
        "endless.bvh": "promises 1,000,000,000 frames, and it holds 1",
        "gone.fbx": "it is a link to a file that does not exist",
        "pipe.fbx": "it is a named pipe, not a file",
        "renamed.bvh": "it is not a BVH file",
    }
    code, output = run(library, tmp_path / "out", "--verbose")
    assert code == 0, output
    told = {file.rsplit("/", 1)[-1]: reason for file, reason in skipped_clips(tmp_path / "out").items()}
    assert set(told) >= set(expected)
    for file, part in expected.items():
        assert part in told[file], file
    assert not any("please report" in reason for reason in told.values()), told
    assert not set(told) & {"folder.fbx", *(file.rsplit("/", 1)[-1] for file in FOUR)}
    for file in told:
        assert file in output


@pytest.mark.slow
def test_labels_of_any_kind_are_kept_and_never_become_paths(tmp_path):
    names = [
        "walk, ein Gang",
        "../../etc/passwd",
        "Walking",
        "walking",
        "歩く",
        "[red]bold[/red]",
        "C:\\x|y?",
    ]
    library = tmp_path / "library"
    library.mkdir()
    amass(library / "not listed.npz")
    draw, rows = np.random.default_rng(1), []
    for number, name in enumerate(names):
        for copy in range(2):
            target = f"clip {number} {copy}.npz"
            amass(library / target, poses=(0.01 * draw.normal(size=(90, 72))).cumsum(axis=0))
            rows.append((target, name, f"{number} {copy}"))
    with (library / "labels.csv").open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream).writerows([("file", "activity", "motion_key"), *rows])
    out = tmp_path / "results" / "out"
    labels = ("--labels", library / "labels.csv", "--exact-labels")
    code, output = run(library, out, *labels, "--patches", 4)
    assert code == 0, output
    assert skipped_clips(out).keys() == {"not listed.npz"}
    content = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    for name in names:
        assert name.split()[0] in output
    assert {path.name for path in tmp_path.iterdir()} == {"library", "results"}
    assert {path.name for path in (tmp_path / "results").iterdir()} == {"out"}
    assert set(content["activities"]) == set(names)


def test_a_library_without_or_with_one_usable_clip_is_said(library, tmp_path):
    for path in (library / "running").iterdir():
        path.write_bytes(b"")
    (library / "walking" / "Walking.fbx").write_bytes(b"")
    code, output = run(library, tmp_path / "one", "--no-report")
    assert code == 1
    assert "No result: a ranking needs two activities that can be tested" in output
    assert "Clips used by activity: walking (1)" in output
    (library / "walking" / "StrutWalking.fbx").write_bytes(b"")
    code, output = run(library, tmp_path / "none", "--no-report")
    assert code == 1
    assert "No result: no clip can be used" in output
    content = json.loads((tmp_path / "none" / "summary.json").read_text())
    assert content["problem"].startswith("no clip can be used")
    assert content["clips"] == {"found": 4, "used": 0, "skipped": 4}
    assert all("empty" in reason for reason in skipped_clips(tmp_path / "none").values())


@pytest.mark.slow
def test_events_for_machines(library, tmp_path):
    (library / "walking" / "empty.fbx").write_bytes(b"")
    arguments = [
        "run",
        library,
        "--out",
        tmp_path / "out",
        "--patches",
        8,
        "--no-pictures",
        "--log-json",
        "--strict",
    ]
    result = CliRunner().invoke(APP, [str(argument) for argument in arguments])
    assert result.exit_code == 3
    events = [json.loads(line) for line in result.output.splitlines()]
    assert all(event["time"].endswith("+00:00") for event in events)
    assert events[0] | {"clips": 5, "activities": {"running": 2, "walking": 3}} == events[0]
    clips = [event for event in events if event["event"] == "clip"]
    assert sorted(clip["done"] for clip in clips) == [1, 2, 3, 4, 5]
    assert [clip["reason"] for clip in clips if not clip["used"]] == ["the file is empty (0 bytes)"]
    assert all(clip["frames"] > 0 for clip in clips if clip["used"])
    assert "ranking patches" in [event.get("step") for event in events]
    assert [event["event"] for event in events[-2:]] == ["result", "finished"]
    assert events[-1]["exit_code"] == 3
    assert events[-2] | {"used": 4, "skipped": 1} == events[-2]


def test_signals_too_large_for_the_memory_are_refused_before_they_are_made(bundled_body, tmp_path):
    from w2w.core.library.library import Clip
    from w2w.core.study.config import StudyConfig
    from w2w.core.study.signals import place_patches
    from w2w.headless.runs.clip import WORK
    from w2w.headless.runs.clip_task import ClipTask, Engine
    from w2w.headless.runs.folder import make_folders

    from .kept_clips import done

    amass(tmp_path / "half an hour.npz", frames=9001, mocap_framerate=np.array(5.0))
    make_folders(tmp_path)
    config = StudyConfig(patches=64)
    bundled_body.save(tmp_path / WORK / "body.npz")
    place_patches(bundled_body, config).save(tmp_path / WORK / "patches.npz")
    clip = Clip(tmp_path / "half an hour.npz", "half an hour.npz", "long", "idle")
    result = done(ClipTask(clip, tmp_path, config, "inputs", Engine(memory=2**28)))
    assert result.reason == (
        "it lasts 30 minutes, and its signals at 64 patches would take 0.1 GiB: cut it into parts of at most "
        "15 minutes, or raise --clip-memory"
    )
    assert not list((tmp_path / "signals").iterdir())


def test_inspect_says_what_is_wrong(shared_data):
    code, output = cli("inspect", shared_data / "mixamo" / "_broken" / "truncated_50pct_Walking.fbx")
    assert code == 1
    assert "would be skipped: it is cut short" in output
