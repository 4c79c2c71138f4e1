# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of clips' records outlives kills and damage."""

import json

import pytest

from w2w.core.library.library import read_library
from w2w.core.study.clip_files import WORK
from w2w.headless.runs.clip_task import ClipTask
from w2w.headless.runs.records import given_names, keeping, read_records, tidy, untouched

from ..kept_clips import done, found


@pytest.fixture
def tasks(motions, four_patches):
    """Three clips of made motion, done."""
    out, config = four_patches
    tasks = [ClipTask(clip, out, config, "inputs") for clip in read_library(motions).clips[:3]]
    assert all(done(task).used for task in tasks)
    return tasks


def names(tasks):
    return [task.clip.name for task in tasks]


def keep(tasks, records, shard=""):
    with keeping(tasks[0].out, {}, shard) as kept:
        for task in tasks:
            kept(records[task.clip.name])


def test_records_are_one_list_from_which_a_clip_is_known_again(tasks):
    out, before = tasks[0].out, read_records(tasks[0].out)
    assert list(before) == names(tasks)
    assert tidy(out) == before == read_records(out)
    listed = (out / WORK / "records.jsonl").read_bytes()
    assert all(untouched(found(task)) == before[task.clip.name] for task in tasks)
    assert all(done(task).used for task in tasks)
    assert (out / WORK / "records.jsonl").read_bytes() == listed  # none was made again


def test_a_line_that_a_kill_cut_short_costs_no_other(tasks):
    out, before = tasks[0].out, read_records(tasks[0].out)
    listed = out / WORK / "records.jsonl"
    lines = listed.read_text().split("\n")
    listed.write_text("\n".join([*lines[:2], '{"clip": "nob']))
    keep(tasks[1:], before)
    assert {name: dict(record, at=0) for name, record in read_records(out).items()} == {
        name: dict(record, at=0) for name, record in before.items()
    }


def test_a_damaged_line_is_no_record_but_leaves_the_files_ours(tasks):
    out, name = tasks[0].out, tasks[0].clip.name
    listed = out / WORK / "records.jsonl"
    lines = listed.read_text().split("\n")
    (number,) = (n for n, line in enumerate(lines) if line.startswith(f'{{"clip": "{name}"'))
    lines[number] = lines[number][:-40]
    listed.write_text("\n".join(lines))
    record = read_records(out)[name]
    assert untouched(found(tasks[0])) is None
    assert given_names(out, name, record) == {
        f"{folder}/{name}.npz": set() for folder in ("motions", "signals")
    }


@pytest.mark.parametrize("other", ["0-of-9", "9-of-9"])
def test_the_newest_of_two_lists_counts_and_one_list_is_left(tasks, other):
    out, name = tasks[0].out, tasks[0].clip.name
    records = dict(read_records(out))
    (out / WORK / "records.jsonl").unlink()
    keep(tasks[:2], records, "1-of-2")
    keep(tasks[2:], records, "2-of-2")
    older = read_records(out)[name] | {"at": 5, "reason": "older"}
    (out / WORK / f"records.{other}.jsonl").write_text(f"\n{json.dumps(older)}\n")
    assert tidy(out)[name]["reason"] == ""
    assert [path.name for path in (out / WORK).glob("records*")] == ["records.jsonl"]
