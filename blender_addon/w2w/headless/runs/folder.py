# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's folder: held and made before the run, and cleared of what earlier runs left."""

import hashlib
import os
import shutil
import socket
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from itertools import chain
from pathlib import Path

from filelock import FileLock, Timeout

from ...core.adopt.topology import NUMBERING
from ...core.body.body import PACKAGE, TEMPLATES
from ...core.files import UNFINISHED, file_sha256
from ...core.findings.summary import PLACEMENTS
from ...core.imu.cover import FITTED
from ...core.library.library import Library, unique_names
from ...core.study.clip_files import CLIP_LIST, MANY_CLIPS, SUBFOLDERS, WORK, divide, mark_changing
from ...core.study.ranking import RANKING_VERSION
from ...core.study.results import UnfinishedError
from ...core.study.signals import SIGNALS_VERSION
from ...core.wording import restated
from .own_files import check, links_in, remove_own
from .records import Records, given_names, read_records, tidy


class FolderBusyError(UnfinishedError):
    """Another run works in the folder; the message says which."""


LOCK, HOLDER = "lock", "holder"
"""Files of the work folder that a run locks, and in which it says who does."""

PREPARING_S = 300.0
"""Seconds that a shard waits for others to place their patches."""


@contextmanager
def only_run(folder: Path) -> Iterator[None]:
    """Hold the folder for this run, or raise a FolderBusyError; the lock goes with the process."""
    holder = folder / HOLDER

    def busy(_: Timeout) -> str:
        who = holder.read_text() if holder.exists() else "another process"
        return f"another run works in {folder.parent} ({who.strip()}): wait for it, or give another --out"

    with restated(busy, Timeout, FolderBusyError), FileLock(folder / LOCK, timeout=0):
        try:
            for path in folder.glob(f"{LOCK}.*"):
                with only_shard(folder, path.name.removeprefix(f"{LOCK}.")):
                    pass
            holder.write_text(f"process {os.getpid()} on {socket.gethostname()}\n")
            yield
        finally:
            holder.unlink(missing_ok=True)


@contextmanager
def only_shard(folder: Path, shard: str) -> Iterator[None]:
    """Hold a shard, such as "17-of-400", next to others of the folder, or raise a FolderBusyError."""
    path = folder / f"{LOCK}.{shard}"
    busy = f"another run makes the shard {shard} in {folder.parent}: wait for it, or give another --out"
    with restated(busy, Timeout, FolderBusyError), FileLock(path, timeout=0):
        try:
            yield
        finally:
            path.unlink(missing_ok=True)


@contextmanager
def preparing(folder: Path) -> Iterator[None]:
    """Hold the folder while a shard writes what all shards share; a FolderBusyError if a run holds it."""
    busy = f"another run works in {folder.parent}: wait for it"
    with restated(busy, Timeout, FolderBusyError), FileLock(folder / LOCK, timeout=PREPARING_S):
        yield


DIVIDED = ("motions", "signals", f"{WORK}/features")
FOLDERS = (*DIVIDED, f"{WORK}/running")
"""Folders for what a run makes of clips, and those of them that have sub-folders where clips are many."""

HEATMAPS = "heatmaps"
MEAN, SUBSET = "mean", "subset"
"""The folder of a study's pictures, and the names of two of them."""

SUMMARY = "summary.json"
TABLES = ("config.json", "utility.npz", "utility.csv", PLACEMENTS, CLIP_LIST, SUMMARY)


def placed_files(out: Path) -> list[Path]:
    """What all clips of a run share: the body, its patches and what covers them."""
    names = (f"{WORK}/body.npz", f"{WORK}/patches.npz", FITTED)
    return [path for name in names if (path := out / name).exists()]


def make_folders(out: Path, clips: int = 0) -> None:
    """Make the folders for what a run makes of clips, of a whole library of `clips`."""
    for folder in FOLDERS:
        (out / folder).mkdir(parents=True, exist_ok=True)
    if clips > MANY_CLIPS:
        for folder in DIVIDED:
            divide(out / folder)


def check_results(out: Path, library: Library, names: Sequence[str]) -> None:
    """`check` a folder for a run that writes `names`, and a motion and signals for each clip."""
    records, clips = read_records(out), {clip.name.lower() for clip in library.clips}
    # in lower case, for where case does not count, and for clips that have changed theirs
    owners: dict[str, list[str]] = {}
    for name in records:
        owners.setdefault(name.lower(), []).append(name)
    # each must be a folder of its own, not a link
    links = {link for folder in DIVIDED for link in links_in(out, folder)}.intersection(_subfolders())
    inside = [f"{folder}/any" for folder in (*FOLDERS, *sorted(links))]
    found = []
    for file in chain(below(out, "motions"), below(out, "signals")):
        clip = file.rpartition("/")[2].removesuffix(NPZ).lower()
        if clip in clips and not any(records.names(name, file) for name in owners.get(clip, ())):
            found.append(file)
    check(out, [*names, *inside, *found])


def _subfolders() -> list[str]:
    return [f"{folder}/{name}" for folder in DIVIDED for name in SUBFOLDERS]


NPZ = ".npz"


def below(out: Path, folder: str) -> Iterator[str]:
    """All that is called a clip's file in one of the folders, by its path in `out`."""
    for place, folders, files in os.walk(out / folder):
        inside = folder + place[len(str(out / folder)) :].replace(os.sep, "/")
        yield from (f"{inside}/{name}" for name in (*folders, *files) if name.endswith(NPZ))


def forget_running(out: Path, clips: set[str]) -> None:
    """Forget which of these clips a run that was killed was at."""
    for marker in (out / WORK / "running").iterdir():
        if marker.name in clips:
            marker.unlink(missing_ok=True)


def remove_leftovers(out: Path, library: set[str], used: set[str], records: Records) -> None:
    """Remove what an earlier run of another library left: the folder holds this study alone.

    `records` are those that the run found. Motions and signals go where they are as a record says; a clip's
    worker has removed those of a clip that is of no use any more. The work folder is all ours.
    """
    stale = {clip: records[clip] for clip in records if clip not in library}
    found = {clip: files for clip, record in stale.items() if (files := given_names(out, clip, record))}
    features = [
        file
        for file in below(out, f"{WORK}/features")
        if file.rpartition("/")[2].removesuffix(NPZ) not in used
    ]
    if found or features:
        mark_changing(out)
    for files in found.values():
        remove_own(out, files)
    if found:
        tidy(out, found)  # a record of no use stays, or its clip would be tried again
    for file in features:
        (out / file).unlink()
    remove_unfinished(out)


def save_new(save: Callable[[Path], None], out: Path, name: str) -> None:
    """Save a file that is not there yet as it is: a shard leaves alone what another reads."""
    path = out / name
    fresh = path.with_name(f".{path.name}{UNFINISHED}")
    save(fresh)
    if path.exists() and file_sha256(path) == file_sha256(fresh):
        fresh.unlink()
    else:
        mark_changing(out)
        fresh.replace(path)


def remove_unfinished(out: Path) -> None:
    """Remove files that a run was writing when it was killed."""
    inside = (*FOLDERS, *_subfolders(), HEATMAPS, WORK)
    for folder in (out, *(out / name for name in inside)):
        for path in () if folder.is_symlink() else folder.glob(f".*{UNFINISHED}"):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)


CODE = ("core", "scene", "drawing", "report", "headless/runs", "headless/reports")
"""Folders of the package whose code results depend on."""

NOT_IN_SIGNALS = ("colour_maps.npz", "demo.npz", "products.json", "sensors.json", "tape_segments.json")
"""Templates that signals do not depend on; a sensor counts by its own model, a parameter of the study."""


@cache
def code_sha256() -> str:
    """Hash of the code and templates that results depend on."""
    code = [path for name in CODE for kind in ("*.py", "*.html") for path in (PACKAGE / name).rglob(kind)]
    return hashlib.sha256((_hash(PACKAGE, code) + _templates_sha256()).encode()).hexdigest()


@cache
def signals_made_by() -> str:
    """Version of what makes signals and features, and a hash of the templates that they depend on."""
    return f"{SIGNALS_VERSION} {_templates_sha256(*NOT_IN_SIGNALS)}"


@cache
def results_made_by() -> str:
    """Versions of what makes signals and ranks, and a hash of all templates."""
    return f"{SIGNALS_VERSION} {RANKING_VERSION} {_templates_sha256()}"


def _templates_sha256(*without: str) -> str:
    files = (*TEMPLATES.glob("*.np[yz]"), *TEMPLATES.rglob("*.json"))
    # the Blender extension lacks that table; a body that was recognised by it is an input of its own
    return _hash(TEMPLATES, (path for path in files if path.name not in (*without, NUMBERING.name)))


def _hash(folder: Path, files: Iterable[Path]) -> str:
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(path.relative_to(folder).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def picture_names(activities: Iterable[str]) -> list[str]:
    """File names of the activities' pictures, distinct from each other and from the other two."""
    return unique_names([MEAN, SUBSET, *(f"{activity}." for activity in activities)])[2:]


def picture_files(activities: Iterable[str]) -> list[str]:
    """The files of a study's pictures, in their folder."""
    return [f"{name}.png" for name in (MEAN, SUBSET, *picture_names(activities))]
