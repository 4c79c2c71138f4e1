# SPDX-License-Identifier: GPL-3.0-or-later
"""A run that replaces results and is killed: whatever reads the folder has one study whole, or says so."""

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import w2w
from w2w.core.study.clip_files import CHANGING, mark_changing
from w2w.core.study.results import UnfinishedError
from w2w.headless.commands import execute, place
from w2w.headless.runs.monitor import read_state
from w2w.headless.runs.study import StudyError
from w2w.headless.runs.workers import EngineError

from ...command_line import cli
from ...here import clips_here
from ...rings import by_day
from ...robustness.resume import UNLIKE, hashes
from ..conftest import QUICKLY

pytestmark = pytest.mark.usefixtures("few_orders", "made_once_here")

ROOT = Path(__file__).resolve().parents[3]
OTHER = ["--window", "2"]
SENTENCE = "holds an unfinished run: run the same command again to finish it, or wait if it is still running"
KILLS = 30


def run(library, out, options=()):
    return cli("run", library, "--out", out, *QUICKLY, *options)


class Moments:
    """Sees a results folder as a kill would leave it before each rename or removal, while it is `on`."""

    def __init__(self):
        self.on, self.see = False, None
        sys.addaudithook(self._hook)  # it cannot be taken away

    def _hook(self, event, _args):
        if self.on and event in ("os.rename", "os.remove", "os.rmdir"):
            self.on = False
            self.see()
            self.on = True

    def during(self, see, work):
        self.see, self.on = see, True
        try:
            return work()
        finally:
            self.on = False


@pytest.fixture(scope="module")
def moments():
    return Moments()


@pytest.fixture(scope="module", autouse=True)
def here():
    """All is done in this process."""
    with clips_here():
        yield


def results(out):
    """Hashes of all that is read of a study, without half-written files and W2W's notes of its runs."""
    notes = (*UNLIKE, "written.sha256", "changing")
    return {
        path.relative_to(out).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in out.rglob("*")
        if path.is_file() and path.name not in notes and not path.name.endswith(".part")
        and path.parent.name not in ("clips", "running")
    }  # fmt: skip


def cut_short(clip):
    clip.write_bytes(clip.read_bytes()[:5000])


CHANGES = {
    "other windows": (OTHER, None),
    "other folds": (["--folds", "3"], None),
    "other patches": (["--seed", "3"], None),
    "a clip less": ([], Path.unlink),
    "a damaged clip": ([], cut_short),
    "nothing": ([], None),
}


BY_DAY = ("a clip less",)
"""A clip is lost, and the rest are ranked again: the others are like it in one or the other."""


def seen_during(moments, out, work):
    """At each moment, whether a folder is said to be unfinished, and its `results` where it is not."""
    seen = []

    def see():
        unfinished = os.path.lexists(out / CHANGING)
        seen.append((unfinished, results(out) if out.is_dir() and not unfinished else {}))

    moments.during(see, work)
    see()
    return seen


@pytest.mark.parametrize("change", by_day(BY_DAY, CHANGES))
def test_at_every_moment_results_are_whole_or_said_to_be_unfinished(moments, quick_run, tmp_path, change):
    library, out, new = (tmp_path / name for name in ("library", "out", "new"))
    shutil.copytree(quick_run / "library", library)
    shutil.copytree(quick_run / "out", out)
    options, changed = CHANGES[change]
    if changed is not None:
        changed(library / "slow" / "slow_3.npz")
    assert run(library, new, options)[0] == 0
    seen = seen_during(moments, out, lambda: run(library, out, options))
    whole = (results(quick_run / "out"), results(new))
    assert all(unfinished or found in whole for unfinished, found in seen)
    assert seen[-1] == (False, whole[1])
    assert hashes(out) == hashes(new)
    assert any(unfinished for unfinished, _ in seen) == (change != "nothing")
    assert len(seen) > (2 if change == "nothing" else 20)


@pytest.mark.slow
def test_a_first_run_is_said_to_be_unfinished_from_its_first_file_to_its_last(moments, quick_run, tmp_path):
    out = tmp_path / "out"
    seen = seen_during(moments, out, lambda: run(quick_run / "library", out))
    whole = results(quick_run / "out")
    assert all(unfinished or found in ({}, whole) for unfinished, found in seen)
    assert seen[-1] == (False, whole)


@pytest.mark.parametrize(("problem", "said"), [(EngineError("gone"), True), (StudyError("no"), False)])
def test_a_run_without_result_leaves_a_folder_that_is_not_read(
    quick_run, tmp_path, monkeypatch, problem, said
):
    out = tmp_path / "out"
    shutil.copytree(quick_run / "out", out)

    def fails(*_):
        raise problem

    with monkeypatch.context() as patch:
        patch.setattr(execute, "rank_study", fails)
        assert run(quick_run / "library", out, ["--folds", "3"])[0] == 1
    code, text = cli("place", out)
    assert (code, SENTENCE in text) == ((4, True) if said else (2, False))
    assert run(quick_run / "library", out)[0] == 0
    assert hashes(out) == hashes(quick_run / "out")


def doors(out, beside, drawn=False):
    """What every reader says of a results folder, or also those that draw; None where it is unfinished."""
    beside.mkdir()
    commands = {
        "place": ["place", out],
        "compare": ["place", out, "--compare", "left wrist, right wrist"],
        "report": ["report", out],
        "export": ["export", out, "--for", "aeon", "--out", beside / "export"],
    }
    if drawn:
        commands |= {"redraw": ["place", out, "--redraw"], "copy": ["place", out, "--out", beside / "copy"]}
    found = {"status": cli("status", out)}
    for name, command in commands.items():
        code, said = cli(*command)
        made = results(out)
        if name == "export" and code == 0:
            said, made = "", results(beside / "export")  # it names its folder, of another length each time
        found[name] = None if code == 4 and SENTENCE in said else (code, "".join(said.split()), made)
    for name, read in (("open_results", opened), ("stream", streamed)):
        try:
            found[name] = read(out)
        except UnfinishedError:
            found[name] = None
    return found


def opened(out):
    ranking = w2w.open_results(out)
    return ranking.answer.sentence(), ranking.wear_together(max_sensors=2).order


def streamed(out):
    return [hashlib.sha256(np.ascontiguousarray(one.acc)).hexdigest() for one in w2w.stream(out)]


def test_every_reader_says_that_a_run_is_unfinished_and_the_same_command_finishes_it(quick_run, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(quick_run / "out", out)
    mark_changing(out)
    before = hashes(out)
    said = doors(out, tmp_path / "doors", drawn=True)
    code, text = said.pop("status")
    assert (code, SENTENCE in text) == (4, True)
    assert set(said.values()) == {None}
    assert hashes(out) == before
    assert "Nothing has changed" in run(quick_run / "library", out)[1]
    assert hashes(out) == hashes(quick_run / "out")
    assert None not in doors(out, tmp_path / "finished").values()
    (out / ".w2w" / "state.json").unlink()
    mark_changing(out)
    assert cli("status", out)[0] == 4


def test_what_a_killed_choice_left_is_gone_after_the_next(quick_run, tmp_path, monkeypatch):
    monkeypatch.setattr(place.draw.Drawing, "save", lambda _: None)
    monkeypatch.setattr(place.draw.Drawing, "finish", lambda *_: {})
    out = shutil.copytree(quick_run / "out", tmp_path / "out")
    (out / ".heatmaps.abc12.w2w.part/heatmaps").mkdir(parents=True)
    left = [out / ".heatmaps.abc12.w2w.part/heatmaps/mean.png", out / ".summary.json.xy.w2w.part"]
    mine = out / ".mine.part"
    for path in (*left, mine):
        path.write_text("half")
    code, said = cli("place", out, "--redraw", "--max", "1")
    assert code == 0, said
    assert [path.name for path in out.glob(".*.part")] == [mine.name]


@pytest.mark.slow
def test_a_choice_that_was_half_written_is_finished_by_the_same_command_or_by_the_run(
    moments, quick_run, tmp_path, monkeypatch
):
    monkeypatch.setattr(place.draw.Drawing, "save", lambda _: None)
    monkeypatch.setattr(place.draw.Drawing, "finish", lambda *_: {})
    choice = ["--redraw", "--max", "1", "--background", "slow"]
    monkeypatch.setattr(place, "check_counting", lambda *_: None)
    drawn, out = tmp_path / "drawn", tmp_path / "out"
    shutil.copytree(quick_run / "out", drawn)
    shutil.copytree(quick_run / "out", out)
    assert cli("place", drawn, *choice)[0] == 0
    whole, states = (results(quick_run / "out"), results(drawn)), []
    assert whole[0] != whole[1]

    def see():
        if os.path.lexists(out / CHANGING):
            states.append(shutil.copytree(out, tmp_path / f"state_{len(states)}"))
        else:
            assert results(out) in whole

    moments.during(see, lambda: cli("place", out, *choice))
    assert len(states) > 5
    assert {cli("report", state)[0] for state in states} == {4}
    for number, state in enumerate(states[:: len(states) // 3]):
        if number % 2:
            assert cli("place", state, *choice)[0] == 0
            assert results(state) == whole[1]
        else:
            assert run(quick_run / "library", state)[0] == 0
            assert results(state) == whole[0]


@pytest.mark.slow
@pytest.mark.usefixtures("all_orders")
def test_killed_at_drawn_moments_every_reader_has_one_study_or_says_so(quick_run, tmp_path):
    library, out = quick_run / "library", tmp_path / "out"
    answers = []
    for options in ([], OTHER):
        assert run(library, out, options)[0] == 0
        shutil.copytree(out, tmp_path / f"study_{len(answers)}")
        answers.append(doors(out, tmp_path / f"doors_{len(answers)}"))
        shutil.rmtree(out)
        shutil.copytree(tmp_path / f"study_{len(answers) - 1}", out)
    expected, rng = hashes(out), np.random.default_rng(0)
    life, unfinished = 0.0, 0
    for kill in range(-1, KILLS):  # the first runs to its end
        shutil.rmtree(out)
        shutil.copytree(tmp_path / "study_0", out)
        began = read_state(out).started
        process = subprocess.Popen(
            [sys.executable, "-m", "headless", "run", library, "--out", out, *QUICKLY, *OTHER],
            cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip
        while process.poll() is None and read_state(out).started == began:
            time.sleep(0.002)
        start = time.monotonic()
        if kill < 0:
            assert process.wait() == 0
            life = time.monotonic() - start
            continue
        time.sleep(rng.uniform(0, life))
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        time.sleep(0.2)  # until its workers are gone, too
        copy = tmp_path / f"killed_{kill}"
        shutil.copytree(out, copy)
        found = doors(out, tmp_path / f"doors_of_{kill}")
        status = found.pop("status")
        unfinished += None in found.values()
        for name, said in found.items():
            assert said in (None, answers[0][name], answers[1][name]), (kill, name, status)
        shutil.rmtree(out)
        shutil.copytree(copy, out)
        assert run(library, out, OTHER)[0] == 0
        assert hashes(out) == expected
    assert unfinished > 0
