# SPDX-License-Identifier: GPL-3.0-or-later
"""A results folder may hold files of the user's: none is ever removed or overwritten."""

import json
import os
import shutil
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from w2w.core.files import file_sha256, write_npz, write_text
from w2w.headless.runs import own_files
from w2w.headless.runs.folder import TABLES, make_folders, remove_leftovers
from w2w.headless.runs.own_files import ForeignFileError, check, claimed, new_file
from w2w.headless.runs.records import read_records

from ...clip_lists import skipped_clips, used_clips
from ...command_line import cli
from ..conftest import QUICKLY

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")

ROOT = Path(__file__).resolve().parents[3]
PRECIOUS = b"years of work"


def run(library, out, *options):
    more = () if "--pictures" in options else ("--no-pictures", "--no-report")
    words = ("--patches", 4, "--workers", 1, "--pose-up", "y")
    return cli("run", library, "--out", out, *words, *options, *more)


def moving(path, seed, scale):
    """A motion of three seconds that no other is like."""
    rng = np.random.default_rng(seed)
    time = np.arange(90)[:, None] / 30
    waves = np.sin(2 * np.pi * time * rng.uniform(0.5, 2, 72) + rng.uniform(0, 6, 72))
    path.parent.mkdir(parents=True, exist_ok=True)
    arrays = {"poses": scale * waves, "trans": np.zeros((90, 3)), "mocap_framerate": np.array(30.0)}
    write_npz(path, arrays)


@pytest.fixture
def library(tmp_path):
    """Two clips of each of two activities."""
    for number, (activity, scale) in enumerate(
        [("calm", 0.05), ("calm", 0.06), ("wild", 0.3), ("wild", 0.4)]
    ):
        moving(tmp_path / "library" / activity / f"{number}.npz", number, scale)
    return tmp_path / "library"


def contents(folder):
    """All files but the lock."""
    return {
        path.relative_to(folder): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != "lock"
    }


def put(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(PRECIOUS)
    return path


@pytest.mark.slow
def test_a_users_files_among_the_results_stay(library, tmp_path):
    out = tmp_path / "out"
    files = ("motions/mine.npz", "signals/mine.npz", "heatmaps/mine.png", ".mine.part", "motions/.mine.part")
    mine = [put(out / file) for file in files]
    assert run(library, out)[0] == 0
    (library / "calm" / "0.npz").rename(library / "calm" / "another.npz")
    edited = out / "signals" / "wild_2.npz"
    (library / "wild" / "2.npz").rename(library / "wild" / "third.npz")
    edited.write_bytes(PRECIOUS)
    assert run(library, out)[0] == 0
    assert [path.read_bytes() for path in (*mine, edited)] == [PRECIOUS] * (len(mine) + 1)
    kept = {path.stem for path in (out / "motions").glob("*.npz")}
    assert kept == {"calm_another", "calm_1", "wild_third", "wild_3", "mine"}
    assert read_records(out).keys() == kept - {"mine"}


@pytest.mark.parametrize("place", ["itself", "a link to it", "its parent", "a link to its parent"])
def test_the_library_is_no_results_folder(library, tmp_path, place):
    out = {
        "itself": library,
        "a link to it": tmp_path / "link",
        "its parent": library / "..",
        "a link to its parent": tmp_path / "link",
    }[place]
    if "link" in place:
        out.symlink_to(tmp_path if "parent" in place else library, target_is_directory=True)
    before = contents(tmp_path)
    code, said = run(library, out)
    assert code == 2
    assert "give the results a folder of their own" in said
    assert ("is the library itself" if place in ("itself", "a link to it") else "holds the library") in said
    assert contents(tmp_path) == before


@pytest.mark.slow
def test_a_results_folder_in_the_library_is_none_of_its_clips(library):
    assert run(library, library / "results")[0] == 0
    before = contents(library)
    assert run(library, library / "results")[0] == 0
    assert len(used_clips(library / "results")) == 4
    assert skipped_clips(library / "results") == {}
    assert contents(library) == before


@pytest.mark.parametrize(
    "name",
    [
        *("motions/calm_0.npz", "signals/wild_2.npz", "report.html", "summary.json", "study.blend"),
        *("config.json", "utility.csv", "utility.npz", "heatmaps/mean.png", "heatmaps/calm.png"),
    ],
)
def test_a_users_file_where_a_result_would_go_is_said(library, tmp_path, name):
    out = tmp_path / "out"
    mine = put(out / name)
    before = contents(out)
    code, said = run(library, out, "--pictures")
    assert code == 2
    assert f"{out} already holds {name}, which W2W did not write and will not overwrite" in said
    assert mine.read_bytes() == PRECIOUS
    assert contents(out) == before


def test_a_users_comparison_of_bodies_is_kept(library, tmp_path):
    mine = put(tmp_path / "out" / "bodies.json")
    code, said = run(library, tmp_path / "out", "--bodies", "female,male")
    assert code == 2
    assert "already holds bodies.json" in said
    assert contents(tmp_path / "out") == {Path("bodies.json"): PRECIOUS}
    assert mine.exists()


@pytest.mark.slow
def test_a_failed_run_gives_up_the_names_it_did_not_use(library, tmp_path):
    out = tmp_path / "out"
    for path in (library / "wild").iterdir():
        path.write_bytes(b"")
    assert run(library, out)[0] == 1
    put(out / "utility.csv")
    code, said = run(library, out)
    assert code == 2
    assert "already holds utility.csv" in said


@pytest.mark.slow
def test_a_clip_that_is_skipped_once_is_used_again(library, tmp_path):
    out = tmp_path / "out"
    clip = library / "calm" / "0.npz"
    whole = clip.read_bytes()
    assert run(library, out)[0] == 0
    clip.write_bytes(b"")
    run(library, out)
    assert not (out / "motions" / "calm_0.npz").exists()
    clip.write_bytes(whole)
    assert run(library, out)[0] == 0
    assert (out / "motions" / "calm_0.npz").exists()


@pytest.mark.slow
def test_a_run_without_result_leaves_none_of_an_earlier_one(library, tmp_path):
    out = tmp_path / "out"
    assert run(library, out, "--report")[0] == 0
    for path in (library / "wild").iterdir():
        path.write_bytes(b"")
    mine = put(out / "heatmaps" / "mine.png")
    code, _ = run(library, out)
    assert code == 1
    assert {path.name for path in out.iterdir()} == {
        ".w2w",
        "clips.jsonl",
        "heatmaps",
        "motions",
        "signals",
        "summary.json",
    }
    assert "problem" in json.loads((out / "summary.json").read_text())
    assert mine.read_bytes() == PRECIOUS


@pytest.mark.slow
def test_a_result_that_the_user_changed_is_kept(library, tmp_path):
    out = tmp_path / "out"
    assert run(library, out)[0] == 0
    (out / "summary.json").write_bytes(PRECIOUS)
    before = contents(out)
    code, said = run(library, out)
    assert (code, contents(out)) == (2, before)
    assert "already holds summary.json" in said


def test_what_was_written_is_listed_with_its_hash_and_without_the_list_is_the_users(library, tmp_path):
    out = tmp_path / "out"
    assert run(library, tmp_path / "finished")[0] == 0
    listed = (tmp_path / "finished" / ".w2w" / "written.sha256").read_text()
    hashes = {name: file_sha256(tmp_path / "finished" / name) for name in sorted(TABLES)}
    assert listed == "".join(f"{value}  {name}\n" for name, value in hashes.items())
    out.mkdir()
    for name in TABLES:
        shutil.copy(tmp_path / "finished" / name, out / name)
    before = contents(out)
    code, said = run(library, out)
    assert code == 2
    assert "already holds config.json, utility.npz, utility.csv and 3 more" in said
    assert contents(out) == before


@pytest.mark.parametrize(
    "refused",
    [
        lambda link: new_file(link),
        lambda link: check(link, ["utility.csv"]),
        lambda link: check(link.parent, [link.name]),
    ],
)
def test_a_link_to_nothing_is_the_users(tmp_path, refused):
    link = tmp_path / "utility.csv"
    link.symlink_to(tmp_path / "unplugged" / "utility.csv")
    with pytest.raises(ForeignFileError):
        refused(link)


def test_a_record_that_points_elsewhere_removes_nothing(tmp_path):
    out = tmp_path / "out"
    make_folders(out)
    mine = [put(tmp_path / "mine.npz"), put(out / "mine.npz"), put(out / "motions" / "mine.npz")]
    for name in ("../mine.npz", str(mine[0]), "motions/../../mine.npz", "mine.npz"):
        record = {"clip": "one", "at": 1, "files": {name: file_sha256(mine[0])}}
        (out / ".w2w" / "records.jsonl").write_text(json.dumps(record))
        with (
            nullcontext()
            if name == "mine.npz"
            else pytest.raises(ForeignFileError, match=r"records\.jsonl, line 1,")
        ):
            remove_leftovers(out, set(), set(), read_records(out))
    assert all(path.read_bytes() == PRECIOUS for path in mine)


def demo_library(folder, *options):
    return cli("demo-library", folder, *options)


@pytest.mark.parametrize("name", ["labels.csv", "shake_head/Shake Head (1).fbx"])
def test_a_users_library_is_not_overwritten_by_the_built_in_one(tmp_path, name):
    mine = put(tmp_path / name)
    code, said = demo_library(tmp_path, "--clips", "1")
    assert code == 2
    assert f"already holds {name}" in said
    assert mine.read_bytes() == PRECIOUS
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [mine]


@pytest.mark.slow
def test_the_built_in_library_is_written_again(tmp_path):
    assert demo_library(tmp_path, "--clips", "2")[0] == 0
    assert demo_library(tmp_path, "--clips", "1")[0] == 0


KILLED = """
import os, sys
from pathlib import Path
from w2w.core.body.body import Body
from w2w.core.files import file_sha256
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.library.library import read_library
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import place_patches
from w2w.headless.runs.clip_task import ClipTask, Engine
from w2w.headless.runs.folder import TABLES, make_folders, remove_leftovers
from w2w.headless.runs.own_files import claimed
from w2w.headless.runs.records import read_records
from tests.headless.kept_clips import done
library, place = read_library(sys.argv[1]), Path(sys.argv[2])
config, body = StudyConfig(patches=4), Body.bundled()
patches = place_patches(body, config)


def folder(name):
    make_folders(place / name)
    body.save(place / name / ".w2w" / "body.npz")
    patches.save(place / name / ".w2w" / "patches.npz")
    return place / name


def do(out, inputs):
    with claimed(out, TABLES):
        return done(ClipTask(library.clips[0], out, config, inputs, Engine(pose=PoseFacts(up="y"))))


def hashes(out):
    return {str(path.relative_to(out)): file_sha256(path) for path in out.rglob("*.npz")}


def killed(out, after):
    pid = os.fork()
    if pid == 0:
        rename = Path.replace

        def counted(path, target):
            nonlocal after
            if after == 0:
                os._exit(9)
            after -= 1
            return rename(path, target)

        Path.replace = counted
        do(out, "new")
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 9


do(folder("undisturbed"), "new")
expected, after, more = hashes(place / "undisturbed"), 0, True
while more:
    out = folder(str(after))
    do(out, "old")
    more = killed(out, after)
    do(out, "new")
    remove_leftovers(out, {library.clips[0].name}, {library.clips[0].name}, read_records(out))
    assert hashes(out) == expected, after
    assert not list(out.rglob("*.part")), after
    out = folder(f"{after} and another library")
    do(out, "old")
    killed(out, after)
    remove_leftovers(out, set(), set(), read_records(out))
    assert [path for path in hashes(out) if not path.startswith(".w2w")] == [], after
    after += 1
print(after)
"""


@pytest.mark.slow
def test_a_kill_at_any_rename_leaves_what_the_next_run_knows_as_its_own(library, tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", KILLED, library, tmp_path],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(done.stdout) >= 8  # renames of a clip, and of the folder's list


@pytest.fixture
def written(tmp_path):
    """A folder with a file that W2W wrote and listed."""
    with claimed(tmp_path / "out", ["table.csv"]):
        write_text(tmp_path / "out/table.csv", "patch,f1\n")
    return tmp_path / "out"


def test_a_damaged_file_of_ours_is_said_to_have_changed_and_what_to_do(written):
    (written / "table.csv").write_bytes(b"patch" + bytes(4))
    with pytest.raises(ForeignFileError) as caught:
        check(written, ["table.csv"])
    said = str(caught.value)
    assert said.startswith(f"{written} already holds table.csv, which changed after W2W wrote it")
    assert said.endswith("delete it if it is damaged, and run the same command again")


def test_a_file_on_no_list_may_be_ours_where_a_run_has_been(written):
    (written / ".w2w/written.sha256").unlink()
    lost = "which W2W did not write and will not overwrite: .*; if a run made it and its list in .w2w is lost"
    with pytest.raises(ForeignFileError, match=lost):
        check(written, ["table.csv"])
    shutil.rmtree(written / ".w2w")
    with pytest.raises(ForeignFileError, match=r"or give another folder$"):
        check(written, ["table.csv"])


def test_a_listed_file_and_the_list_are_on_the_disk_before_they_have_their_names(tmp_path, monkeypatch):
    waited_for, named = set(), []
    sync, replace = os.fsync, Path.replace

    def synced(handle):
        sync(handle)
        waited_for.add(os.fstat(handle).st_ino)

    def renamed(path, target):
        named.append((target.name, path.stat().st_ino in waited_for))
        return replace(path, target)

    monkeypatch.setattr(own_files.os, "fsync", synced)
    monkeypatch.setattr(Path, "replace", renamed)
    with claimed(tmp_path / "out", ["table.csv"]):
        write_text(tmp_path / "out/table.csv", "patch,f1\n")
    assert named == [("written.sha256", True), ("table.csv", True), ("written.sha256", True)]


def test_clips_that_change_the_case_of_their_names_keep_their_folder(quick_run, tmp_path):
    library, out = (shutil.copytree(quick_run / name, tmp_path / name) for name in ("library", "out"))
    (library / "slow").rename(library / "Slow")
    for path in (library / "Slow").iterdir():
        path.rename(path.with_name(path.name.title()))
    code, said = cli("run", library, "--out", out, *QUICKLY)
    assert code == 0, said
    clips = [f"fast_fast_{n}" for n in range(4)] + [f"Slow_Slow_{n}" for n in range(4)]
    for folder in ("motions", "signals"):
        assert sorted(path.stem for path in (out / folder).glob("*.npz")) == sorted(clips)
