# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip is worked on again when anything its result depends on has changed."""

import os
from dataclasses import replace

import pytest

from w2w.core.body.body import Body
from w2w.core.clip_files import WORK
from w2w.core.library.library import Clip, read_library
from w2w.core.study import StudyConfig, place_patches
from w2w.headless.runs import clip, clip_task, records
from w2w.headless.runs.clip import do_clip
from w2w.headless.runs.clip_task import ClipTask, Engine
from w2w.headless.runs.folder import make_folders


@pytest.mark.parametrize("changed", [{"activity": "run"}, {"subject": "bo"}, {"name": "b"}])
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
    first = do_clip(task)
    assert first.used
    before = files(task)
    monkeypatch.setattr(clip, "file_sha256", None)
    monkeypatch.setattr(clip_task, "file_sha256", None)
    monkeypatch.setattr(records, "file_sha256", None)
    assert do_clip(task) == first
    assert files(task) == before


def test_damage_that_keeps_size_and_time_is_found_by_verify(task):
    do_clip(task)
    before = files(task)
    times = task.signals_file.stat()
    damaged = bytearray(before[task.signals_file])
    damaged[len(damaged) // 2] ^= 1
    task.signals_file.write_bytes(damaged)
    os.utime(task.signals_file, ns=(times.st_atime_ns, times.st_mtime_ns))
    do_clip(task)
    assert task.signals_file.read_bytes() == damaged
    do_clip(replace(task, engine=Engine(verify=True)))
    assert files(task) == before


@pytest.mark.parametrize("way", ["rewritten", "replaced", "linked anew"])
def test_another_file_of_the_same_size_and_an_older_time_is_another_clip(task, way):
    path = task.clip.path
    do_clip(task)
    before, times = task.signals_file.read_bytes(), path.stat()
    other = bytearray((path.parent / "fast_1.npz").read_bytes())
    assert len(other) == times.st_size
    if way == "rewritten":
        path.write_bytes(other)
        os.utime(path, ns=(0, 0))
    else:
        old = path.with_name("old.bin")
        old.write_bytes(other)
        os.utime(old, ns=(0, 0))
        if way == "replaced":
            old.replace(path)
        else:
            path.unlink()
            path.symlink_to(old)
    assert do_clip(task).used
    assert task.signals_file.read_bytes() != before


def test_a_file_that_changes_while_it_is_read_is_read_again(task, monkeypatch):
    make = clip._make

    def slowly(work):
        os.utime(work.clip.path)
        return make(work)

    monkeypatch.setattr(clip, "_make", slowly)
    do_clip(task)
    assert records.untouched(task, records.last_record(task)) is None
    monkeypatch.undo()
    assert do_clip(task).used
