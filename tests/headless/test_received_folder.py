# SPDX-License-Identifier: GPL-3.0-or-later
"""A results folder that somebody else made: nothing outside it is read, written or removed."""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from w2w.core.files import file_sha256, write_npz

from ..command_line import cli
from ..rings import by_day

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")

LIST, RECORDS = ".w2w/written.sha256", ".w2w/records.jsonl"
RUN = ["--patches", "4", "--workers", "1", "--no-pictures"]


def moving(path: Path, seed: int, scale: float) -> None:
    """A motion of three seconds that no other is like."""
    rng = np.random.default_rng(seed)
    time = np.arange(90)[:, None] / 30
    waves = np.sin(2 * np.pi * time * rng.uniform(0.5, 2, 72) + rng.uniform(0, 6, 72))
    path.parent.mkdir(parents=True, exist_ok=True)
    arrays = {"poses": scale * waves, "trans": np.zeros((90, 3)), "mocap_framerate": np.array(30.0)}
    write_npz(path, arrays)


@pytest.fixture(scope="module")
def sent(made_once) -> Path:
    """A library and a finished results folder."""

    def make(folder: Path) -> None:
        for number, (activity, scale) in enumerate(
            [("calm", 0.05), ("calm", 0.06), ("wild", 0.3), ("wild", 0.4), ("calm", 0.07)]
        ):
            moving(folder / "library" / activity / f"{number}.npz", number, scale)
        code, said = cli("run", folder / "library", "--out", folder / "out", *RUN)
        assert code == 0, said

    return made_once("sent", make)


@pytest.fixture
def place(sent, tmp_path) -> Path:
    """A folder with the library, `out` as it was received, and files elsewhere, equal to those of `out`."""
    for name, target in (("library", "library"), ("out", "out"), ("out", "elsewhere")):
        shutil.copytree(sent / name, tmp_path / target)
    rows = [f"{name}/{n}.npz,{name}" for name, n in [("calm", 0), ("calm", 1), ("wild", 2), ("wild", 3)]]
    (tmp_path / "fewer.csv").write_text("\n".join(["file,activity", *rows]))
    (tmp_path / "elsewhere" / "thesis.txt").write_text("years of work")
    (tmp_path / "elsewhere" / ".mine.w2w.part").write_text("unfinished")
    return tmp_path


def commands(place: Path) -> dict[str, list[object]]:
    """Every command that reads a results folder, or writes into one that is there."""
    out, library = place / "out", place / "library"
    return {
        "place": ["place", out, "--max", 1],
        "redraw": ["place", out, "--max", 1, "--redraw"],
        "copy": ["place", out, "--max", 1, "--out", place / "new"],
        "compare": ["place", out, "--compare", "wrist, ankle"],
        "report": ["report", out],
        "aeon": ["export", out, "--for", "aeon", "--places", "all"],
        "xsens": ["export", out, "--for", "xsens", "--places", "all"],
        "status": ["status", out],
        "run": ["run", library, "--out", out, *RUN],
        "verify": ["run", library, "--out", out, "--verify", *RUN],
        "shard": ["run", library, "--out", out, "--shard", "1/2", *RUN],
        "bodies": ["run", library, "--out", out, "--bodies", "female,male", *RUN],
        "fewer": ["run", library, "--labels", place / "fewer.csv", "--out", out, *RUN],
    }


def everything(folder: Path) -> dict[str, object]:
    """All that is in a folder: content and times of files, targets of links."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_symlink():
            found[str(path)] = str(path.readlink())
        elif path.is_file():
            found[str(path)] = (path.read_bytes(), path.stat().st_mtime_ns)
        else:
            found[str(path)] = "folder"
    return found


opened: list[str] = []
watching = False


def _watch(event: str, details: tuple) -> None:
    if watching and event == "open" and isinstance(details[0], str | bytes | os.PathLike):
        opened.append(os.path.realpath(os.fsdecode(details[0])))


@contextmanager
def untouched(folder: Path) -> Iterator[None]:
    """Fail where the block reads, writes or removes anything in a folder."""
    global watching
    if not hasattr(sys, "_w2w_watched"):
        sys.addaudithook(_watch)
        sys._w2w_watched = True
    before = everything(folder)
    opened.clear()
    watching = True
    try:
        yield
    finally:
        watching = False
    assert everything(folder) == before
    assert [path for path in opened if Path(path).is_relative_to(os.path.realpath(folder))] == []


def edit(path: Path, change: Callable[[str], str]) -> None:
    path.write_text(change(path.read_text("utf-8")), "utf-8")


def names_of(place: Path) -> list[str]:
    """Names that lead to the files elsewhere, and some that no system takes."""
    there = place / "elsewhere"
    ways = [
        "../elsewhere/",
        "heatmaps/../../elsewhere/",
        "motions/../../elsewhere/",
        f"{there}/",
        "./../elsewhere/",
    ]
    files = ["thesis.txt", "summary.json", "motions/calm_0.npz", "motions/calm_0"]
    odd = ["", ".", "..", "C:\\thesis.txt", "\\\\host\\thesis.txt", "a\0b", "..\\elsewhere\\thesis.txt"]
    return [way + file for way in ways for file in files] + odd


def listed(place: Path, name: str) -> None:
    """The list says that W2W wrote a file of such a name: with its hash, and with one of noughts."""
    file = place / "out" / name if "\0" not in name else place
    hashes = ["0" * 64, *([file_sha256(file)] if file.is_file() else ())]
    edit(place / "out" / LIST, lambda text: text + "".join(f"{value}  {name}\n" for value in hashes))


def recorded(place: Path, name: str) -> None:
    """Clips' records name a file: of all, for they lie in any order, and a shard reads its own clips'."""

    def change(text: str) -> str:
        records = [json.loads(line) for line in text.splitlines() if line]
        for record in records:
            record["files"] = dict.fromkeys([name, *record["files"]], "0" * 64)
            record["bytes"] = dict.fromkeys(record["files"], 13)
        return "\n".join(["", *map(json.dumps, records)]) + "\n"

    edit(place / "out" / RECORDS, change)


def clip_recorded(place: Path, name: str) -> None:
    """A record is of a clip of such a name."""

    def change(text: str) -> str:
        record = json.loads(text.splitlines()[1])
        files = {f"{folder}/{name}.npz": "0" * 64 for folder in ("motions", "signals")}
        return f"{text}\n{json.dumps({**record, 'clip': name, 'files': files}, ensure_ascii=False)}\n"

    edit(place / "out" / RECORDS, change)


def clip_listed(place: Path, name: str) -> None:
    """The list of clips names one."""

    def change(text: str) -> str:
        first, *rest = text.splitlines()
        return "\n".join([json.dumps({**json.loads(first), "clip": name}), *rest]) + "\n"

    edit(place / "out" / "clips.jsonl", change)


NAMING = {
    "listed": (listed, ["run", "redraw", "report", "shard"]),
    "recorded": (recorded, ["run", "shard"]),
    "clip_recorded": (clip_recorded, ["run", "verify", "shard"]),
    "clip_listed": (clip_listed, ["place", "redraw", "copy", "compare", "report", "aeon", "xsens"]),
}


OUT = ["../elsewhere/thesis.txt", "/{there}/thesis.txt", "", "..", "C:\\x", "\\\\h\\x"]
"""Names that lead out: by day `core/test_inside.py` refuses the others."""


@pytest.mark.parametrize("how", NAMING)
@pytest.mark.parametrize("name", by_day(OUT[:1], OUT))
def test_a_name_that_leads_out_is_refused_with_file_and_line(place, how, name):
    change, refusing = NAMING[how]
    change(place, name.format(there=place / "elsewhere"))
    for word in refusing:
        with untouched(place / "elsewhere"):
            code, said = cli(*commands(place)[word])
        assert code == 2, (word, said)
        if name or how != "clip_recorded":
            assert ", line " in said, (word, said)
        assert "leads out of the folder" in said


LINKS = [
    *(
        "summary.json",
        "config.json",
        "clips.jsonl",
        "utility.npz",
        "motions",
        "signals",
        ".w2w",
        ".w2w/body.npz",
    ),
    *(
        ".w2w/patches.npz",
        ".w2w/features",
        "signals/calm_0.npz",
        "motions/calm_0.npz",
        ".w2w/features/calm_0.npz",
    ),
    *(LIST, RECORDS, ".w2w/running", ".w2w/state.json", ".w2w/lock", ".w2w/holder", "export"),
    *(".w2w/current.json", "heatmaps", "report.html", "study.blend", ".x.w2w.part"),
]
READ = {
    "place": ["summary.json", "config.json", "clips.jsonl", "utility.npz", ".w2w", ".w2w/patches.npz"],
    "report": ["summary.json", "config.json", "clips.jsonl", "utility.npz", ".w2w", ".w2w/body.npz"],
    "xsens": ["summary.json", "motions", "motions/calm_0.npz", "export", ".w2w/body.npz"],
    "aeon": ["signals", "signals/calm_0.npz", "export", ".w2w"],
    "status": [".w2w", ".w2w/state.json", ".w2w/lock"],
    "run": [
        "motions",
        "signals",
        "motions/calm_0.npz",
        "signals/wild_2.npz",
        ".w2w",
        ".w2w/features",
        LIST,
        RECORDS,
        ".w2w/holder",
    ],
    "bodies": ["female"],
    "fewer": ["motions", "motions/calm_4.npz", "signals/calm_4.npz", RECORDS],
    "redraw": [".w2w", ".w2w/holder", "report.html", "heatmaps", "study.blend"],
}


def link(place: Path, name: str, relative: bool = False) -> None:
    """Put a link to the equal file or folder elsewhere in the place of one in the results."""
    path, target = place / "out" / name, place / "elsewhere" / name
    if path.is_dir():
        shutil.rmtree(path)
    elif path.exists():
        path.unlink()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.symlink_to(os.path.relpath(target, path.parent) if relative else target)


EACH = [(word, name) for word, names in READ.items() for name in names]
BY_DAY = {name: (word, name) for word, name in reversed(EACH)}.values()


@pytest.mark.parametrize(("word", "name"), by_day(BY_DAY, EACH))
def test_a_link_that_leads_out_is_refused(place, word, name):
    link(place, name)
    with untouched(place / "elsewhere"):
        code, said = cli(*commands(place)[word])
    assert code in ((1, 2) if word in ("xsens", "aeon") else (2,)), said
    assert re.search(
        "link that leads out of the folder|which W2W did not write|changed after W2W wrote it", said
    )


def own_placements(place: Path, name: str) -> None:
    """Patches bear a name that leads out."""
    with np.load(place / "out" / ".w2w/patches.npz") as stored:
        arrays = dict(stored)
    count = len(arrays["vertices"])
    arrays["own_names"] = np.array([f"{name} {n}".replace("\0", "") for n in range(count)])
    write_npz(place / "out" / ".w2w/patches.npz", arrays)


def worded(place: Path, name: str, rng: np.random.Generator) -> None:
    """Any text in one of the tables is the name."""
    file = rng.choice(["config.json", "summary.json", ".w2w/current.json", ".w2w/state.json", "clips.jsonl"])
    texts: list[tuple[dict | list, object]] = []

    def find(value: object) -> None:
        pairs = (
            value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        )
        for key, inner in list(pairs):
            if isinstance(inner, str):
                texts.append((value, key))
            find(inner)

    lines = (place / "out" / file).read_text("utf-8").splitlines() if file == "clips.jsonl" else None
    content = (
        [json.loads(line) for line in lines]
        if lines
        else json.loads((place / "out" / file).read_text("utf-8"))
    )
    find(content)
    if texts:
        inside, key = texts[rng.integers(len(texts))]
        inside[key] = name
    text = "\n".join(map(json.dumps, content)) if lines else json.dumps(content)
    (place / "out" / file).write_text(text, "utf-8")


@pytest.mark.parametrize("seed", by_day((0, 3, 5), range(150)))
def test_whatever_a_received_folder_says_nothing_elsewhere_is_touched(place, seed):
    rng = np.random.default_rng(seed)
    ways = [listed, recorded, clip_recorded, clip_listed, own_placements]
    for _ in range(rng.integers(1, 4)):
        name = str(rng.choice(np.array(names_of(place), dtype=object)))
        what = rng.integers(8)
        if what < len(ways):
            try:
                ways[what](place, name)
            except (FileNotFoundError, NotADirectoryError, json.JSONDecodeError):
                continue  # another change took the file away
        elif what == 5:
            try:
                worded(place, name, rng)
            except (FileNotFoundError, NotADirectoryError):
                continue
        elif not any((place / "out" / part).is_symlink() for part in (".w2w", "motions", "signals")):
            link(place, str(rng.choice(LINKS)), relative=what == 6)
    words = rng.permutation(list(commands(place)))[:4]
    if rng.integers(2):  # a library of which nothing is left that can be ranked
        for path in (place / "library" / "wild").iterdir():
            path.write_bytes(b"")
    for word in words:
        with untouched(place / "elsewhere"):
            code, said = cli(*commands(place)[word])
        assert code in (0, 1, 2, 4), said
        assert "please report" not in said
    assert {path.name for path in place.iterdir()} <= {"elsewhere", "library", "out", "new", "fewer.csv"}
