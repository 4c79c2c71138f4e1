# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of clips' records outlives kills and damage."""

import json
from dataclasses import replace

import pytest

from w2w.core.library.library import read_library
from w2w.core.study.clip_files import WORK
from w2w.headless.runs.clip import do_clip
from w2w.headless.runs.clip_task import ClipTask
from w2w.headless.runs.records import gather, given_names, read_records, tidy, untouched


@pytest.fixture
def tasks(motions, four_patches):
    """Three clips of made motion, done."""
    out, config = four_patches
    tasks = [ClipTask(clip, out, config, "inputs") for clip in read_library(motions).clips[:3]]
    assert all(do_clip(task).used for task in tasks)
    return tasks


def names(tasks):
    return [task.clip.name for task in tasks]


def test_gathered_records_say_what_the_files_said(tasks):
    out, before = tasks[0].out, read_records(tasks[0].out)
    gather(out, names(tasks)[:2])
    assert [task.record_file.exists() for task in tasks] == [False, False, True]
    assert read_records(out) == before
    assert tidy(out) == before == read_records(out)
    assert not tasks[2].record_file.exists()
    tasks = [replace(task, before=before.text(task.clip.name)) for task in tasks]
    assert all(do_clip(task) == untouched(task, before[task.clip.name]) for task in tasks)
    assert all(not task.record_file.exists() for task in tasks)  # none was made again


def test_a_line_that_a_kill_cut_short_costs_no_other(tasks):
    out, before = tasks[0].out, read_records(tasks[0].out)
    gather(out, names(tasks)[:1])
    listed = out / WORK / "records.jsonl"
    listed.write_text(listed.read_text() + '\n{"clip": "nob')
    gather(out, names(tasks)[1:])
    assert read_records(out) == before


def test_a_damaged_line_is_no_record_but_leaves_the_files_ours(tasks):
    out, name = tasks[0].out, tasks[0].clip.name
    gather(out, names(tasks))
    listed = out / WORK / "records.jsonl"
    lines = listed.read_text().split("\n")
    (number,) = (n for n, line in enumerate(lines) if line.startswith(f'{{"clip": "{name}"'))
    lines[number] = lines[number][:-40]
    listed.write_text("\n".join(lines))
    record = read_records(out)[name]
    assert untouched(tasks[0], record) is None
    assert given_names(out, name, record) == {
        f"{folder}/{name}.npz": set() for folder in ("motions", "signals")
    }


@pytest.mark.parametrize("other", ["0-of-9", "9-of-9"])
def test_the_newest_of_two_lists_counts_and_one_list_is_left(tasks, other):
    out, name = tasks[0].out, tasks[0].clip.name
    gather(out, names(tasks)[:2], "1-of-2")
    gather(out, names(tasks)[2:], "2-of-2")
    older = read_records(out)[name] | {"at": 5, "reason": "older"}
    (out / WORK / f"records.{other}.jsonl").write_text(f"\n{json.dumps(older)}\n")
    assert tidy(out)[name]["reason"] == ""
    assert [path.name for path in (out / WORK).glob("records*")] == ["records.jsonl"]
