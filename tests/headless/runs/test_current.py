# SPDX-License-Identifier: GPL-3.0-or-later
"""The same command once more ranks nothing, unless something has changed."""

import hashlib
import json
import os
import shutil
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from w2w.core.study import results
from w2w.headless.app import APP
from w2w.headless.commands import execute, run as command
from w2w.headless.study_options import StudyOptions

from ...command_line import cli
from ...drifting import WithDrift
from ...robustness.resume import UNLIKE
from ..conftest import QUICKLY, write_motions

QUICK = ["--no-report"]

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")


def run(library, out, *options):
    code, said = cli("run", library, "--out", out, *QUICKLY, *options)
    assert code == 0, said
    return said


@pytest.fixture
def ranked(quick_run, tmp_path, monkeypatch):
    """A library with results, and how often the study was ranked after that."""
    library, out, times = tmp_path / "library", tmp_path / "out", []
    for folder in (library, out):
        shutil.copytree(quick_run / folder.name, folder)
    assert "Nothing has changed" in run(library, out)  # it knows the copies by their looks from now on
    rank = execute.rank_study
    monkeypatch.setattr(execute, "rank_study", lambda *given: (times.append(1), rank(*given))[1])
    return library, out, times


def test_sizes_and_times_tell_that_nothing_has_changed(ranked, monkeypatch):
    library, out, times = ranked
    read, make, look = [], execute.make_signals, command.look_up
    monkeypatch.setattr(execute, "make_signals", lambda *given: (read.append(1), make(*given))[1])
    monkeypatch.setattr(command, "look_up", lambda *given: (read.append(1), look(*given))[1])

    def looked_into():
        read.clear()
        assert "Nothing has changed" in run(library, out)
        return bool(read)

    motion, features = sorted(library.rglob("*.npz"))[0], sorted((out / ".w2w" / "features").iterdir())[0]
    status = (out / ".w2w" / "state.json").read_bytes()
    assert not looked_into()
    assert (out / ".w2w" / "state.json").read_bytes() == status
    motion.touch()
    assert looked_into()
    assert not looked_into()
    assert run(library, out, "--log-json").count('"event": "clip"') == 8
    content = bytearray(features.read_bytes())
    content[-1] ^= 1
    features.write_bytes(content)  # as long as it was
    assert looked_into()
    assert not looked_into()
    (out / ".w2w" / "patches.npz").unlink()
    assert looked_into()
    motion.touch()
    with monkeypatch.context() as patch:
        patch.setattr(
            execute, "make_signals", lambda *given: (make(*given), read.append(1), motion.touch())[0]
        )  # its file changes again after the run has read it
        assert looked_into()
    assert looked_into()
    assert not looked_into()
    assert not times


@pytest.mark.slow
def test_a_clip_that_was_not_done_is_tried_again_though_nothing_looks_otherwise(ranked, monkeypatch):
    library, out, _ = ranked
    make = execute.make_signals

    def killed(*given):
        made = make(*given)
        first = replace(made.clips[0], reason="not done yet", details={}, source_sha256="")
        return replace(made, clips=(first, *made.clips[1:]))

    def used():
        return json.loads((out / "summary.json").read_text())["clips"]["used"]

    with monkeypatch.context() as patch:
        patch.setattr(execute, "make_signals", killed)
        run(library, out, *QUICK)
    assert used() == 7
    assert "Nothing has changed" not in run(library, out, *QUICK)
    assert used() == 8


def swap(one, other):
    beside = one.with_name("swapped")
    one.rename(beside)
    other.rename(one)
    beside.rename(other)


def replace_each(first, second):
    """Give each file the other version's content, but leave it its size and times."""
    for path in sorted(first.rglob("*.npz")):
        times = path.stat()
        path.write_bytes((second / path.relative_to(first)).read_bytes())
        assert path.stat().st_size == times.st_size
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def set_clock(folder, seconds):
    """Let records in a results folder be written by a clock that was so much ahead."""
    for path in (folder / ".w2w").glob("records*.jsonl"):
        records = [json.loads(line) for line in path.read_text().splitlines() if line]
        shifted = [record | {"at": record["at"] + seconds * 10**9} for record in records]
        path.write_text("".join(f"\n{json.dumps(record)}" for record in shifted))


WAYS = (
    "a link leads elsewhere", "a folder is moved into place", "two folders are swapped",
    "each file keeps its size and time", "another folder is given",
)  # fmt: skip


def change(way, link, first, second):
    """Let a library, given by a link to its first version, be the second; where that is given."""
    if way == WAYS[0]:
        link.unlink()
        link.symlink_to(second)
    elif way == WAYS[1]:
        first.rename(first.with_name("old"))
        second.rename(first)
    elif way == WAYS[2]:
        swap(first, second)
    elif way == WAYS[3]:
        replace_each(first, second)
    return second if way == WAYS[4] else link


@pytest.fixture(scope="module")
def versions(tmp_path_factory):
    """Two versions of a library with the same names and sizes."""
    folder = tmp_path_factory.mktemp("versions")
    write_motions(folder / "v1", {"slow": 0.5, "fast": 2.0}, 4)
    write_motions(folder / "v2", {"slow": 0.7, "fast": 1.6}, 4)
    return folder


def results_of(library, out):
    run(library, out, *QUICK)
    return hashes(out)


@pytest.fixture(scope="module")
def fresh(versions, one_worker):  # noqa: ARG001
    """What the second version gives."""
    return results_of(versions / "v2", versions / "out")


def switched(way, v1, v2, fresh, place, ahead=0):
    """Whether results of a library's first version become those of its second, and stay."""
    for name, version in (("v1", v1), ("v2", v2)):
        shutil.copytree(version, place / name)
    link, out = place / "DATA", place / "out"
    link.symlink_to(place / "v1")
    run(link, out, *QUICK)
    set_clock(out, ahead)
    library = change(way, link, place / "v1", place / "v2")
    return [
        "Nothing has changed" not in run(library, out, *QUICK),
        hashes(out) == fresh,
        "Nothing has changed" in run(library, out, *QUICK),
    ]


AHEAD = 10**7
"""Seconds that a clock is ahead."""


@pytest.mark.parametrize(
    ("way", "ahead"),
    [
        (WAYS[3], 0),
        *(pytest.param(way, 0, marks=pytest.mark.slow) for way in WAYS if way != WAYS[3]),
        *(pytest.param(way, AHEAD, marks=pytest.mark.slow) for way in WAYS[2:4]),
    ],
)
def test_the_answer_is_of_the_library_that_lies_there_now(versions, fresh, tmp_path, way, ahead):
    assert switched(way, versions / "v1", versions / "v2", fresh, tmp_path, ahead) == [True] * 3


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_the_answer_is_of_the_real_library_that_lies_there_now(shared_cases, tmp_path, way):
    fresh = results_of(shared_cases / "v2", tmp_path / "fresh")
    assert switched(way, shared_cases / "v1", shared_cases / "v2", fresh, tmp_path) == [True] * 3


def hashes(out):
    files = [path for path in out.rglob("*") if path.is_file() and path.name not in UNLIKE]
    return {path.relative_to(out): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.slow
def test_motions_that_are_read_otherwise_are_ranked_anew(ranked):
    library, out, times = ranked
    before = (out / "utility.csv").read_bytes()
    assert "Nothing has changed" not in run(library, out, "--pose-rate", "20")
    assert len(times) == 1
    assert (out / "utility.csv").read_bytes() != before


def test_a_new_parameter_has_signals_made_anew_with_no_more_than_its_declaration(ranked, monkeypatch):
    library, out, times = ranked
    monkeypatch.setattr(results, "StudyConfig", WithDrift)  # where a folder's own parameters are read
    config, features = StudyOptions.config, sorted((out / ".w2w" / "features").iterdir())
    for drift, made, ranked_times in ((0.0, True, 1), (0.0, False, 1), (2.0, True, 2)):
        monkeypatch.setattr(
            StudyOptions, "config", lambda options, d=drift: WithDrift(**vars(config(options)), drift=d)
        )
        before = [path.stat().st_mtime_ns for path in features]
        run(library, out, *QUICK)
        assert all((path.stat().st_mtime_ns > at) == made for path, at in zip(features, before, strict=True))
        assert len(times) == ranked_times


@pytest.mark.slow
def test_the_same_command_ranks_only_what_has_changed(ranked):
    library, out, times = ranked
    before, answer = hashes(out), json.loads((out / "summary.json").read_text())["answer"]
    said = run(library, out)
    assert said.index(answer["sentence"]) < said.index("Nothing has changed since the last run")
    sorted((out / "signals").iterdir())[0].unlink()  # made again as it was
    assert "Nothing has changed" in run(library, out)
    assert hashes(out) == before
    assert not times

    clips = sorted(library.rglob("*.npz"))
    (out / "report.html").unlink()
    run(library, out)
    assert len(times) == 1
    assert hashes(out) == before
    assert CliRunner().invoke(APP, ["place", str(out), "--max", "2", "--redraw"]).exit_code == 0
    run(library, out)
    assert len(times) == 2
    (out / ".w2w" / "current.json").write_text("{")
    run(library, out)
    assert len(times) == 3
    clips[0].rename(clips[-1].with_name("moved.npz"))
    run(library, out)
    assert len(times) == 4
    clips[1].unlink()
    run(library, out, "--folds", "3")
    assert len(times) == 5
    assert "Nothing has changed" in run(library, out, "--folds", "3")
    assert len(times) == 5
