# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a folder's results are those that a run would write: then it need not rank again.

Sizes and times tell it in seconds, whatever the library; where they changed, what the results were made of.
"""

import hashlib
import json
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import Any

from ...core.body.body import Body
from ...core.files import file_sha256, stamp, write_json
from ...core.findings.summary import versions
from ...core.given import inside
from ...core.library.library import Clip
from ...core.study.clip_files import WORK
from .clip_task import digest_of_path, look
from .covers import files_worn
from .folder import DIVIDED, below, placed_files, results_made_by
from .own_files import LIST, is_whole
from .records import lists_in, size_and_time
from .study import BakedStudy, RunPlan

CURRENT = f"{WORK}/current.json"
"""Digests of the inputs of the results, of how all files looked then, and of the list of results."""


def note_current(plan: RunPlan, baked: BakedStudy, out: Path, inputs: str) -> None:
    """Note what the results in a folder, which are all there now, were made of.

    `inputs` is `looks_of_inputs` before the run read any of them: a file that changed since looks different.
    """
    # what no hash is known of was not read, and perhaps could be now
    is_settled = all(clip.source_sha256 or not stamp(clip.clip.path) for clip in baked.clips)
    looks = _looks(baked.body, out, inputs) if is_settled else ""
    write_json(out / CURRENT, _content(plan, baked, out) | {"looks": looks})


def looks_of_inputs(plan: RunPlan) -> str:
    """A digest of how a study is made and within which limits, of its labels, and how its files look."""
    library = digest_of_path(plan.library.folder)
    clips = [(*_labels(clip), look(library, clip.path)) for clip in plan.library.clips]
    parts = [_asked(plan), plan.engine.limits, *clips]
    return _digest([*parts, *map(stamp, filter(None, files_worn(plan.config)))])


def is_untouched(body: Body, out: Path, inputs: str) -> bool:
    """Whether the results are all there and, by the looks of all files, would come out the same."""
    with suppress(OSError):  # a folder is gone
        noted = _noted(out).get("looks")  # none in a folder that holds no results, whatever else it holds
        return bool(noted) and noted == _looks(body, out, inputs) and is_whole(out)
    return False


def is_current(plan: RunPlan, baked: BakedStudy, out: Path) -> bool:
    """Whether the results are all there, unchanged, and would come out the same."""
    with suppress(OSError):  # there are no results yet
        return _content(plan, baked, out).items() <= _noted(out).items() and is_whole(out)
    return False


def _noted(out: Path) -> dict[str, str]:
    try:
        noted = json.loads((out / CURRENT).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return noted if isinstance(noted, dict) else {}


def _content(plan: RunPlan, baked: BakedStudy, out: Path) -> dict[str, str]:
    seen = plan.engine.ups, plan.engine.rests  # they follow from the files, whose looks stand for them
    clips = ((*_labels(result.clip), result.reason, result.source_sha256) for result in baked.clips)
    return {
        "made_of": _digest([_asked(plan), *seen, *map(file_sha256, placed_files(out)), *clips]),
        "written": file_sha256(out / LIST),
    }


def _looks(body: Body, out: Path, inputs: str) -> str:
    """A digest of the inputs' looks, the body, and sizes and times of the folder's files."""
    arrays = (body.vertices, body.faces, body.joints, body.weights)
    parts: list[Any] = [inputs, body.name, *(hashlib.sha256(array.data).hexdigest() for array in arrays)]
    for folder in DIVIDED:
        inside(out, folder)  # no link leads elsewhere
        parts += [[name, *size_and_time(f"{out}/{name}")] for name in sorted(below(out, folder))]
    return _digest([*parts, *map(stamp, (out / LIST, *placed_files(out), *lists_in(out)))])


def _asked(plan: RunPlan) -> tuple[Any, ...]:
    library, engine = plan.library, plan.engine
    return (
        plan.config.as_dict(), versions(), results_made_by(), plan.pictures, plan.report, plan.more,
        library.labelled_by, library.skipped, library.check,
        engine.bone_maps, engine.pose, engine.signals,
    )  # fmt: skip


def _labels(clip: Clip) -> tuple[Any, ...]:
    return tuple(getattr(clip, item.name) for item in fields(clip) if item.name != "path")


def _digest(parts: list[Any]) -> str:
    return hashlib.sha256(repr(parts).encode("utf-8", "backslashreplace")).hexdigest()
