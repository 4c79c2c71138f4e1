# SPDX-License-Identifier: GPL-3.0-or-later
"""One rule for every command: the user's files stay, no output is an input, refusals come before the work."""

import shutil
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from w2w.headless.reports import draw
from w2w.headless.runs import workers
from w2w.headless.runs.own_files import ForeignFileError, claimed, published

from ..command_line import cli
from ..rings import by_day

PRECIOUS = b"years of work"


pytestmark = pytest.mark.usefixtures("motions", "made_once_here")


@pytest.fixture(scope="module")
def kept(tmp_path_factory, drawn_results, shared_data):
    """Something of each kind that commands read."""
    folder = tmp_path_factory.mktemp("kept")
    shutil.copytree(drawn_results, folder / "results")
    shutil.copy(next((shared_data / "bvh").rglob("*.bvh")), folder / "clip.bvh")
    groups = "activity,group\nslow,communicative_gesture\nfast,communicative_gesture\n"
    (folder / "groups.csv").write_text(groups)
    (folder / "weights.csv").write_text("activity,weight\nsitting,2\n")
    (folder / "sensor.json").write_text("{}")
    (folder / "real.csv").write_text("time_s\n")
    (folder / "gait").mkdir()
    np.savez(folder / "data.npz", x=np.zeros(3))
    assert cli("sensors", "bmi270", "--out", folder / "mine.json")[0] == 0
    return folder


@pytest.fixture
def place(tmp_path, kept, monkeypatch):
    """A working directory with a copy of that; no work can begin in it."""

    def begun(*_):
        raise AssertionError("work began")

    monkeypatch.chdir(shutil.copytree(kept, tmp_path, dirs_exist_ok=True))
    for module in (workers, draw):
        monkeypatch.setattr(module, "local_executor", begun)
    return tmp_path


def everything(folder):
    """Every file with its bytes, every link with its end, every folder."""
    return {
        path.relative_to(folder): path.readlink()
        if path.is_symlink()
        else (path.read_bytes() if path.is_file() else "folder")
        for path in folder.rglob("*")
    }


FILE = {  # commands that write one file
    "synth": "synth clip.bvh --patch sternum --out OUT",
    "synth --plot": "synth clip.bvh --patch sternum --out new.csv --plot OUT",
    "synth x-io": "synth clip.bvh --patch sternum --format x-io --out OUT",
    "place": "place results --out OUT",
    "tables": "tables results --out OUT",
    "sensors": "sensors mine.json --out OUT",
    "calibrate": "calibrate real.csv clip.bvh --patch sternum --out OUT",
}
FOLDER = {  # commands that write into a folder, and a name in it that they need
    "run": ("run motions --out OUT", "report.html"),
    "run, a clip": ("run motions --out OUT", "motions/fast_fast_0.npz"),
    "run, a picture": ("run motions --out OUT", "heatmaps/slow.png"),
    "run, several bodies": ("run motions --out OUT --bodies female,male", "bodies.json"),
    "run, the second body": ("run motions --out OUT --bodies female,male", "male/utility.csv"),
    "study mixamo": ("study mixamo motions --out OUT --labels labels.csv --groups groups.csv", "trends.csv"),
    "study library": ("study library motions --out OUT --labels labels.csv --fewest 2", "library.csv"),
    "study rehab": ("study rehab --out OUT", "results/figure.png"),
    "study rehab, quality": ("study rehab --out OUT", "quality/report.html"),
    "study truth": ("study truth motions --out OUT --dsads data.npz", "truth.md"),
    "study need": ("study need motions --out OUT --dsads data.npz", "needs.md"),
    "challenge": ("challenge --out OUT --dsads data.npz", "challenge.md"),
    "demo": ("demo --out OUT", "results/summary.json"),
    "demo, its library": ("demo --out OUT", "library/shake_head_1.npz"),
    "demo, its labels": ("demo --out OUT", "library/labels.csv"),
    "demo-library": ("demo-library OUT", "labels.csv"),
    "sweep": ("sweep results --out OUT", "places.csv"),
    "export": ("export results --for aeon --out OUT", "README.md"),
    "place": ("place results --out OUT", "anything"),
    "validate dsads": ("validate dsads data.npz motions --out OUT", "report.md"),
    "validate utd-mhad": ("validate utd-mhad data.npz --out OUT", "report.md"),
    "validate mmfit": ("validate mmfit gait --out OUT", "report.md"),
    "validate vidimu": ("validate vidimu gait --out OUT", "report.md"),
    "validate gait": ("validate gait gait --out OUT", "signals.json"),
    "validate mhad": ("validate mhad data.npz motions --out OUT", "summary.json"),
    "validate umafall": ("validate umafall data.npz motions --out OUT", "summary.json"),
    "validate upfall": ("validate upfall data.npz motions --out OUT", "summary.json"),
    "validate mighar": ("validate mighar gait motions --sensors weights.csv --out OUT", "summary.json"),
}
BY_DAY = [name for name in FOLDER if name.split()[0] not in ("study", "validate", "challenge")]
"""The studies' commands are their own suite's, which runs by night, too."""

IN_RESULTS = {  # commands that write into the results folder they read
    "report": ("report results", "report.html"),
    "tables": ("tables results", "tables.csv"),
    "place --redraw": ("place results --redraw", "study.blend"),
    "need": ("need results", "placements.csv"),
    "sweep": ("sweep results", "sweep/sweep.csv"),
    "export": ("export results --for aeon", "export/aeon/mine.txt"),
}


def arguments(line, out):
    """The words of a line; where it names labels, they are there."""
    if "labels.csv" in line:
        rows = [
            f"{path.relative_to('motions')},{path.parent.name},A" for path in Path("motions").rglob("*.npz")
        ]
        Path("labels.csv").write_text("\n".join(["file,activity,source", *rows]) + "\n")
    return [out if word == "OUT" else word for word in line.split()]


def inside(command):
    """The folder in OUT that the foreign file of a command lies in, and its sentence names."""
    first = FOLDER[command][1].partition("/")[0]
    return f"{first}/" if first in ("male", "results", "quality", "library") else ""


def put(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(PRECIOUS)


def refused(place, words, because):
    """Run a command that must be refused: a sentence, exit code 2, and nothing is otherwise than before."""
    before = everything(place)
    code, said = cli(*words)
    assert everything(place) == before
    assert code == 2, said
    assert because in said, said


@pytest.mark.parametrize("command", FILE)
def test_no_file_is_replaced(place, command):
    out = "mine.out.json" if command in ("place", "sensors", "calibrate") else "mine.out"
    put(place / out)
    refused(place, arguments(FILE[command], out), f"{out} is already there")
    Path(out).unlink()
    Path(out).symlink_to("nowhere")
    refused(place, arguments(FILE[command], out), f"{out} is already there")


@pytest.mark.parametrize(
    "line",
    [
        "synth clip.bvh --patch sternum --out clip.bvh",
        "synth clip.bvh --patch sternum --out new.csv --plot clip.bvh",
        "synth clip.bvh --patch sternum --sensor mine.json --format npz --out mine.json",
        "sensors mine.json --out ./mine.json",
        "calibrate real.csv clip.bvh --patch sternum --sensor mine.json --out mine.json",
        "tables results --groups groups.csv --out groups.csv",
        "place results --weights weights.csv --out results/summary.json",
    ],
)
def test_no_file_is_its_own_input(place, line):
    refused(place, line.split(), "is already there")


def test_one_file_is_not_two(place):
    refused(place, "synth clip.bvh --patch sternum --out new --plot new".split(), "two files at once")


def test_a_file_goes_into_a_folder_that_is_there(place):
    refused(place, "synth clip.bvh --patch sternum --out no/new.csv".split(), "there is no folder no")


@pytest.mark.parametrize("command", by_day(BY_DAY, FOLDER))
def test_a_foreign_file_in_the_way_is_kept(place, command):
    line, name = FOLDER[command]
    words = arguments(line, "out")
    put(place / "out" / name)
    refused(
        place,
        words,
        "out is not empty" if command == "place" else f"already holds {name.removeprefix(inside(command))}",
    )


@pytest.mark.parametrize("command", by_day(BY_DAY, FOLDER))
def test_a_file_is_no_folder(place, command):
    line, _ = FOLDER[command]
    words = arguments(line, "out")
    said = "out is not empty" if command == "place" else "is not a folder: give another one"
    put(place / "out")
    refused(place, words, said)
    if command != "place":
        Path("out").unlink()
        Path("out").symlink_to("nowhere")
        refused(place, words, said)


@pytest.mark.parametrize("command", IN_RESULTS)
def test_a_foreign_file_among_the_results_is_kept(place, command):
    line, name = IN_RESULTS[command]
    put(place / "results" / name)
    refused(place, line.split(), f"already holds {Path(name).name}")


@pytest.mark.parametrize("command", by_day([*FILE, *BY_DAY], [*FILE, *FOLDER]))
def test_an_empty_name_is_no_working_directory(place, command):
    line = FILE.get(command) or FOLDER[command][0]
    refused(place, arguments(line, ""), "is empty: name a file or a folder")
    refused(place, [word.replace("--out", "--out=") for word in arguments(line, "") if word], "is empty") if (
        "--out OUT" in line
    ) else None


@pytest.mark.parametrize("name", ["motions", "signals", ".w2w", "heatmaps"])
@pytest.mark.parametrize("kind", ["link", "file"])
def test_what_stands_for_a_folder_of_a_run_is_seen_before_it(place, name, kind):
    (place / "elsewhere").mkdir()
    (place / "out").mkdir()
    if kind == "link":
        (place / "out" / name).symlink_to("../elsewhere", target_is_directory=True)
    else:
        put(place / "out" / name)
    refused(place, ["run", "motions", "--out", "out"], f"out already holds {name}, which W2W did not write")


def test_labels_of_one_activity_are_refused_before_any_work(place):
    Path("one.csv").write_text("file,activity\nslow/slow_0.npz,walk\nslow/slow_1.npz,walk\n")
    because = "a ranking needs two activities that can be tested, and there is only walk"
    refused(place, ["run", "motions", "--labels", "one.csv", "--out", "out"], because)
    Path("one.csv").write_text("file,activity\nslow/slow_0.npz,walk\nslow/slow_1.npz,jump\n")
    because = "there is none: jump, walk: each has only one clip"
    refused(place, ["run", "motions", "--labels", "one.csv", "--out", "out"], because)
    refused(
        place,
        ["run", "motions", "--labels", "one.csv", "--out", "out"],
        "Put all clips of an activity into one folder",
    )


def test_what_needs_blender_is_refused_before_any_work_where_it_is_not_installed(place, monkeypatch):
    from w2w.headless import blender

    shutil.copy("clip.bvh", "motions/fast/one.fbx")
    monkeypatch.setattr(blender, "find_spec", lambda _: None)
    monkeypatch.delitem(blender.sys.modules, "bpy", raising=False)
    before = everything(place)
    code, said = cli("run", "motions", "--out", "out")
    assert (code, everything(place)) == (1, before)
    assert "No result: Blender's Python module, bpy, is not installed" in said


def test_an_export_is_replaced_and_what_the_user_put_beside_it_stays(place):
    words = ["export", "results", "--for", "xsens", "--places", "sternum"]
    Path("results/export").mkdir()

    def write(folder, **files):
        with published(folder) as new:
            for name, text in files.items():
                (new / name).parent.mkdir(exist_ok=True)
                (new / name).write_text(text)

    target = Path("results/export/xsens")
    write(target, a="1", b="2")
    write(target, a="3", c="4")
    assert {path.name for path in target.iterdir()} == {".w2w", "a", "c"}
    assert (target / "a").read_text() == "3"
    put(target / "notes.txt")
    refused(place, words, "already holds notes.txt, which W2W did not write")
    (target / "notes.txt").unlink()
    (target / "a").write_text("edited")
    refused(place, words, "already holds a, which changed after W2W wrote it")


NAMES = st.sampled_from(["a", "b", "c", "in/a", "in/b", "deep/in/a"])
WHAT = st.sampled_from([*("file", "link", "folder"), "edited", "gone"])


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(NAMES, unique=True, max_size=4), st.dictionaries(NAMES, WHAT, max_size=4), st.data())
def test_whatever_the_user_does_in_a_folder_is_his(tmp_path_factory, written, done, data):
    """Files written, then disturbed: the next write leaves each byte of the user's, or is refused whole."""
    folder = tmp_path_factory.mktemp("any") / "out"
    with suppress_clash(), claimed(folder, written):
        for name in written:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(f"ours {name}")
    for name, what in done.items():
        disturb(folder / name, what)
    theirs = {path: told for path, told in everything(folder).items() if not ours(path, told)}
    again = data.draw(st.lists(NAMES, unique=True, max_size=4))
    how = data.draw(st.sampled_from(["claimed", "published"]))
    before = everything(folder)
    try:
        with ExitStack() as stack:
            place = stack.enter_context(published(folder)) if how == "published" else folder
            if how == "claimed":
                stack.enter_context(claimed(folder, again))
            for name in again:
                (place / name).parent.mkdir(parents=True, exist_ok=True)
                (place / name).write_text(f"ours {name} again")
    except ForeignFileError:
        assert everything(folder) == before
    after = everything(folder)
    assert {path: after.get(path) for path in theirs} == theirs
    assert not list(folder.parent.glob(".*"))


def ours(path, told):
    return (
        path.parts[0] == ".w2w" or told == "folder" or (isinstance(told, bytes) and told.startswith(b"ours"))
    )


def suppress_clash():
    """A name may be another's folder: then nothing is written."""
    from contextlib import suppress

    return suppress(FileExistsError, NotADirectoryError, IsADirectoryError)


def disturb(path, what):
    """What a user does at a path; what cannot be done there is left."""
    with suppress_clash():
        path.parent.mkdir(parents=True, exist_ok=True)
        if what == "edited":
            path.write_bytes(PRECIOUS)
            return
        if path.is_file() or path.is_symlink():
            path.unlink()
        if what == "file":
            path.write_bytes(PRECIOUS)
        elif what == "link" and not path.exists():
            path.symlink_to(path.parent.parent / "elsewhere")
        elif what == "folder":
            path.mkdir(exist_ok=True)
