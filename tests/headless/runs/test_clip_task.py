# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip is worked on again when anything its result depends on has changed."""

import os
import shutil
from dataclasses import replace

import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.library.library import Clip, read_library
from w2w.core.motion.motion import Motion
from w2w.core.study.clip_files import WORK
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import place_patches
from w2w.headless.runs import clip, clip_task, records
from w2w.headless.runs.clip_task import ClipTask, Engine
from w2w.headless.runs.folder import make_folders

from ...seen_joints import seen_as
from ..kept_clips import done, found


@pytest.mark.parametrize("changed", [{"activity": "run"}, {"subject": "bo"}, {"name": "b"}, {"rate": 30.0}])
def test_another_label_is_another_key(tmp_path, changed):
    clip = Clip(tmp_path / "a.bvh", "a.bvh", name="a", activity="walk", subject="al")
    task = ClipTask(clip, tmp_path, StudyConfig(), "inputs")
    assert replace(task, clip=replace(clip, **changed)).key("0") != task.key("0") == replace(task).key("0")
    assert task.key("1") != task.key("0")


@pytest.fixture
def task(motions, bundled_body, tmp_path):
    """A clip of made motion, in a folder of its own."""
    out, config = tmp_path / "out", StudyConfig(patches=8)
    make_folders(out)
    bundled_body.save(out / WORK / "body.npz")
    place_patches(Body.bundled(), config).save(out / WORK / "patches.npz")
    return ClipTask(read_library(motions).clips[0], out, config, "inputs")


def files(task):
    return {path: path.read_bytes() for path in task.out.rglob("*") if path.is_file()}


def test_what_is_as_it_was_is_not_read_again(task, monkeypatch):
    first = done(task)
    assert first.used
    before = files(task)
    monkeypatch.setattr(clip, "file_sha256", None)
    monkeypatch.setattr(clip_task, "file_sha256", None)
    monkeypatch.setattr(records, "file_sha256", None)
    assert done(task) == first
    assert files(task) == before


def test_a_rate_in_the_labels_makes_the_clip_anew_and_goes_before_that_of_all(task):
    own = done(task).details["frame_rate"]
    for_all = replace(task, engine=Engine(pose=PoseFacts(rate=own / 2)), inputs="others")
    labelled = replace(for_all, clip=replace(task.clip, rate=own / 4))
    assert done(for_all).details["frame_rate"] == own / 2
    assert done(labelled).details["frame_rate"] == own / 4


def test_damage_that_keeps_size_and_time_is_found_by_verify(task):
    done(task)
    before = files(task)
    times = task.signals_file.stat()
    damaged = bytearray(before[task.signals_file])
    damaged[len(damaged) // 2] ^= 1
    task.signals_file.write_bytes(damaged)
    os.utime(task.signals_file, ns=(times.st_atime_ns, times.st_mtime_ns))
    done(task)
    assert task.signals_file.read_bytes() == damaged
    done(replace(task, engine=Engine(verify=True)))
    after = files(task)
    listed = task.out / WORK / "records.jsonl"
    assert {**after, listed: before[listed]} == before


@pytest.mark.parametrize("age", ["older", "as old", "younger"])
@pytest.mark.parametrize("way", ["rewritten", "replaced", "linked anew"])
def test_another_file_of_the_same_size_is_another_clip_whatever_its_time(task, way, age):
    path = task.clip.path
    done(task)
    before, times = task.signals_file.read_bytes(), path.stat()
    other = bytearray((path.parent / "fast_1.npz").read_bytes())
    assert len(other) == times.st_size
    time = times.st_mtime_ns + {"older": -(10**15), "as old": 0, "younger": 10**15}[age]
    if way == "rewritten":
        path.write_bytes(other)
        os.utime(path, ns=(time, time))
    else:
        old = path.with_name("old.bin")
        old.write_bytes(other)
        os.utime(old, ns=(time, time))
        if way == "replaced":
            old.replace(path)
        else:
            path.unlink()
            path.symlink_to(old)
    assert done(task).used
    assert task.signals_file.read_bytes() != before


@pytest.mark.parametrize("times", [1, clip.READS])
def test_a_file_that_changes_while_it_is_read_is_read_again(task, monkeypatch, times):
    make, path = clip._make, task.clip.path
    versions = [path.read_bytes(), (path.parent / "fast_1.npz").read_bytes()]
    read = []

    def slowly(work):
        read.append(1)
        if len(read) <= times:
            path.write_bytes(versions[len(read) % 2])  # after its hash, before its content
        made = make(work)
        if len(read) <= times:
            path.write_bytes(versions[0])  # which no hash taken later could tell
        return made

    monkeypatch.setattr(clip, "_make", slowly)
    result = done(task)
    assert len(read) == min(times + 1, clip.READS)
    assert result.used == (times < clip.READS)
    assert result.used or "changes while it is being read" in result.reason
    monkeypatch.undo()
    assert done(task).used
    signals = task.signals_file.read_bytes()
    (task.out / WORK / "records.jsonl").unlink()
    assert done(task).used
    assert task.signals_file.read_bytes() == signals  # of the file as it is


def test_a_file_that_only_looks_otherwise_is_hashed_once_and_not_made_again(task, monkeypatch):
    result, path = done(task), task.clip.path
    path.chmod(0o600)
    path.rename(path.with_suffix(".moved"))
    shutil.copy2(path.with_suffix(".moved"), path)
    monkeypatch.setattr(clip, "_make", None)
    assert records.untouched(found(task)) is None
    assert done(task) == result
    assert records.untouched(found(task))
    elsewhere = replace(task, library="/elsewhere")
    assert records.untouched(found(elsewhere)) is None
    assert done(elsewhere) == result
    assert records.untouched(found(elsewhere))


def test_a_side_car_that_keeps_its_size_and_time_is_read_again(task, bundled_body, tmp_path):
    path = tmp_path / "seen.npy"
    np.save(path, seen_as(JOINT_SETS["coco-17"], bundled_body, Motion.load(task.clip.path)))
    facts = path.with_suffix(".json")
    facts.write_text('{"rate": 30, "up": "z"}')
    seen = replace(task, clip=Clip(path, "seen.npy", "seen", "walk"))
    at = facts.stat().st_mtime_ns
    assert done(seen).details["frame_rate"] == 30
    facts.write_text('{"rate": 60, "up": "z"}')
    os.utime(facts, ns=(at, at))
    assert done(seen).details["frame_rate"] == 60
