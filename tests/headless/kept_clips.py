# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips done as a run does them: with what it finds of them before, and with their records kept."""

from contextlib import closing
from dataclasses import replace

from w2w.headless.runs.clip import do_clip
from w2w.headless.runs.records import keeping, read_records, result_of, untouched
from w2w.headless.runs.workers import Crew, run_tasks


def found(task):
    """The task with the clip's record by an earlier run."""
    return replace(task, before=read_records(task.out).text(task.clip.name))


def done(task):
    """The result of a clip, done here."""
    task = found(task)
    record = None if task.engine.verify else untouched(task)
    if record is None:
        record = do_clip(task)
        with keeping(task.out, read_records(task.out)) as keep:
            keep(record)
    return result_of(task.clip, record)


def run_all(tasks, workers, scheduler="", crew=None):
    """The results of tasks done by workers, in their order."""
    clips, results = {task.clip.name: task.clip for task in tasks}, {}
    with keeping(tasks[0].out, read_records(tasks[0].out)) as keep:

        def came(record):
            keep(record)
            results[record["clip"]] = result_of(clips[record["clip"]], record)

        with closing(crew or Crew()) as those:
            run_tasks(tasks, workers, scheduler, came, those)
    return [results[name] for name in clips]
