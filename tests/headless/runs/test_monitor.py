# SPDX-License-Identifier: GPL-3.0-or-later
"""One call a step: what is shown, what programs are told, and what `w2w status` reads."""

import ast
import io
import json
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pytest
from rich.console import Console

from w2w.core.library.library import Clip, Library
from w2w.core.study.results import ClipResult
from w2w.headless.runs.folder import make_folders
from w2w.headless.runs.monitor import EventLog, RunMonitor, read_state
from w2w.headless.runs.study import _with_bar

HEADLESS = Path(__file__).resolve().parents[3] / "blender_addon/w2w/headless"
SEWN_TOGETHER = [
    *sorted((HEADLESS / "runs").glob("*.py")),
    HEADLESS / "commands/execute.py",
    HEADLESS / "reports/draw.py",
]
MOST_PARAMETERS = 5


@pytest.fixture
def screen():
    return Console(file=io.StringIO(), width=100)


@pytest.fixture
def told():
    return io.StringIO()


def events(told):
    found = [json.loads(line) for line in told.getvalue().splitlines()]
    return [{name: value for name, value in event.items() if name != "time"} for event in found]


def library(folder):
    clips = tuple(Clip(folder / f"{name}.bvh", f"{name}.bvh", name, "walk") for name in "ab")
    return Library(folder, clips, "folder names", (("c.bvh", "the file labels.csv does not list it"),))


def test_a_step_is_shown_told_and_kept_by_one_call(tmp_path, screen, told):
    make_folders(tmp_path)
    monitor = RunMonitor(screen, EventLog(told))
    monitor.begin(library(tmp_path), "neutral", tmp_path)
    with monitor.step("placing patches", "Placing patches on the body"):
        assert read_state(tmp_path).step == "placing patches"
    with monitor.bar("turning motions to signals", 2) as advance:
        for clip, reason in zip(library(tmp_path).clips, ("", "it is empty"), strict=True):
            monitor.clip_done(ClipResult(clip, reason, {"windows": 3}, ""))
            advance(1)
    monitor.announce("finished", "no heatmaps: no screen")
    assert events(told) == [
        {"event": "started", "out": str(tmp_path), "body": "neutral", "clips": 2, "activities": {"walk": 2}},
        {"event": "clip", "file": "c.bvh", "used": False, "reason": "the file labels.csv does not list it"},
        {"event": "step", "step": "placing patches"},
        {"event": "step", "step": "turning motions to signals"},
        {"event": "clip", "file": "a.bvh", "used": True, "done": 1, "of": 2, "windows": 3},
        {"event": "clip", "file": "b.bvh", "used": False, "done": 2, "of": 2, "reason": "it is empty"},
        {"event": "step", "step": "finished"},
    ]
    state = read_state(tmp_path)
    assert (state.step, state.message) == ("finished", "no heatmaps: no screen")
    assert (state.clips, state.done, state.skipped) == (2, 2, 1)
    shown = screen.file.getvalue()
    assert "Placing patches on the body: " in shown
    assert "Turning motions to signals: " in shown


def test_a_step_in_two_parts_is_told_once(tmp_path, screen, told):
    make_folders(tmp_path)
    monitor = RunMonitor(screen, EventLog(told))
    with monitor.bar("drawing", 3, "Drawing heatmaps"):
        pass
    with monitor.step("drawing", "Saving study.blend"):
        pass
    assert events(told) == [{"event": "step", "step": "drawing"}]
    assert "Drawing heatmaps: " in screen.file.getvalue()
    assert "Saving study.blend: " in screen.file.getvalue()


def test_a_step_that_fails_is_not_said_to_be_done(screen):
    with pytest.raises(ValueError, match="no such place"), RunMonitor(screen).step("choosing patches"):
        raise ValueError("no such place")
    assert "Choosing patches: " not in screen.file.getvalue()


def test_a_second_run_of_one_monitor_begins_anew(tmp_path, screen):
    monitor = RunMonitor(screen)
    for name in ("female", "male"):
        make_folders(tmp_path / name)
        monitor.begin(library(tmp_path), name, tmp_path / name)
        monitor.clip_done(ClipResult(library(tmp_path).clips[0], "", {}, ""))
        monitor.announce("finished")
    states = [read_state(tmp_path / name) for name in ("female", "male")]
    assert [(state.step, state.done) for state in states] == [("finished", 1)] * 2


def test_without_a_folder_nothing_is_written(tmp_path, screen, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with RunMonitor(screen).step("reading MM-Fit"):
        pass
    assert "Reading MM-Fit: " in screen.file.getvalue()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("file", SEWN_TOGETHER, ids=lambda file: file.name)
def test_no_function_is_handed_more_than_a_few_things(file):
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            names = [argument.arg for argument in given if argument.arg not in ("self", "cls")]
            assert len(names) <= MOST_PARAMETERS, f"{node.name}({', '.join(names)})"


def test_a_rankings_bar_goes_by_what_is_done_and_ends_full():
    steps = []
    monitor = SimpleNamespace(bar=lambda *_: nullcontext(steps.append))

    def rank(progress):
        for done in (0.25, 0.25, 0.6, 1.0):
            progress(done)
        return "ranked"

    assert _with_bar(rank, monitor) == "ranked"
    assert steps == [25, 0, 35, 40]
