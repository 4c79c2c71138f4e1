# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a folder's results are those that a run would write: then it need not rank again.

Sizes and times tell it in seconds, whatever the library; where they changed, what the results were made of.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from operator import attrgetter
from pathlib import Path
from typing import Any

from w2w.core.body.body import Body
from w2w.core.files import file_sha256, write_json
from w2w.core.findings.summary import versions
from w2w.core.garments.cover import FITTED
from w2w.core.garments.cut import split_name
from w2w.core.inside import inside
from w2w.core.library.library import Clip
from w2w.core.study.clip_files import WORK

from .clip_task import Looks, digest_of_path, look, stamp
from .folder import DIVIDED, code_sha256
from .own_files import LIST, is_whole
from .records import forget_read, lists_in, read_records
from .study import Made, RunPlan

CURRENT = f"{WORK}/current.json"
"""What the results in the folder were made of, how all files looked then, and the list of results."""

PLACED = (f"{WORK}/body.npz", f"{WORK}/patches.npz", FITTED)


def note_current(plan: RunPlan, made: Made, out: Path, garments: list[list[int]]) -> None:
    """Note what the results in a folder, which are all there now, were made of.

    `garments` are `garment_stamps` before the run read them; how clips looked then is in their records.
    """
    clips = _looks_as_read(plan, made, out)
    looks = "" if clips is None else _looks(plan, made.body, out, clips, garments)
    write_json(out / CURRENT, _content(plan, made, out) | {"looks": looks})


def garment_stamps(plan: RunPlan) -> list[list[int]]:
    """The `stamp` of each garment's file."""
    return [stamp(Path(file)) for garment in plan.config.garments if (file := split_name(garment)[0])]


def is_untouched(plan: RunPlan, body: Body, out: Path) -> bool:
    """Whether the results are all there and, by the looks of all files, would come out the same."""
    noted = _noted(out).get("looks")
    if not noted:
        return False
    library = digest_of_path(plan.library.folder)
    clips = [look(library, clip.path) for clip in plan.library.clips]
    with suppress(OSError):  # a folder is gone
        return noted == _looks(plan, body, out, clips, garment_stamps(plan)) and is_whole(out)
    return False


def is_current(plan: RunPlan, made: Made, out: Path) -> bool:
    """Whether the results are all there, unchanged, and would come out the same."""
    with suppress(OSError):  # there are no results yet
        return _content(plan, made, out).items() <= _noted(out).items() and is_whole(out)
    return False


def _noted(out: Path) -> dict[str, str]:
    try:
        noted = json.loads((out / CURRENT).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return noted if isinstance(noted, dict) else {}


def _content(plan: RunPlan, made: Made, out: Path) -> dict[str, str]:
    placed = (path for name in PLACED if (path := out / name).exists())
    clips = ((*_labels(one.clip), one.reason, one.source_sha256) for one in made.clips)
    return {
        "made_of": _digest([_study(plan), *map(file_sha256, placed), *clips]),
        "written": file_sha256(out / LIST),
    }


def _looks_as_read(plan: RunPlan, made: Made, out: Path) -> list[Looks] | None:
    """How each clip looked before the run read it; None where that is not known of all."""
    records, library = read_records(out), digest_of_path(plan.library.folder)
    forget_read()
    found = []
    for result in made.clips:
        try:
            source = records[result.clip.name]["source"]
            looks = source["looks"] if source["sha256"] == result.source_sha256 else []
        except (KeyError, TypeError):
            looks = []
        if not looks and stamp(result.clip.path):  # it was not read, and perhaps could be now
            return None
        found.append(looks or look(library, result.clip.path))
    return found


def _looks(plan: RunPlan, body: Body, out: Path, clips: Sequence[Looks], garments: list[list[int]]) -> str:
    """A digest of labels, the looks of clips and garments, and sizes and times of the folder's files."""
    arrays = (body.vertices, body.faces, body.joints, body.weights)
    parts = [_study(plan), body.name]
    parts += [hashlib.sha256(array).hexdigest() for array in arrays]
    parts += [(*_labels(clip), looks) for clip, looks in zip(plan.library.clips, clips, strict=True)]
    for folder in DIVIDED:
        parts += _files_below(out, folder)
    shared = (*(out / name for name in (LIST, *PLACED)), *lists_in(out))
    return _digest([*parts, *garments, *map(stamp, shared)])


def _study(plan: RunPlan) -> tuple[Any, ...]:
    library, engine, flags = plan.library, plan.engine, (plan.pictures, plan.report, plan.more)
    words = library.labelled_by, library.skipped, library.check
    words += engine.bone_maps, engine.pose, engine.ups, engine.signals
    return (plan.config.as_dict(), versions(), code_sha256(), *flags, *words)


def _labels(clip: Clip) -> tuple[str, ...]:
    return clip.file, clip.name, clip.activity, clip.subject, clip.motion_key, clip.source


def _files_below(out: Path, folder: str) -> Iterator[tuple[str, int, int]]:
    """Path, size and time of each file below a folder, which is given by its path in `out`."""
    with os.scandir(inside(out, folder)) as entries:
        for entry in sorted(entries, key=attrgetter("name")):
            if entry.is_dir(follow_symlinks=False):
                yield from _files_below(out, f"{folder}/{entry.name}")
            else:
                found = entry.stat(follow_symlinks=False)
                yield f"{folder}/{entry.name}", found.st_size, found.st_mtime_ns


def _digest(parts: list[Any]) -> str:
    return hashlib.sha256(repr(parts).encode("utf-8", "backslashreplace")).hexdigest()
