# SPDX-License-Identifier: GPL-3.0-or-later
"""What a .blend file of a finished run holds for W2W's panel: the study as text, to be shown again as it was.

The extension need not be there when the file is written, nor when it is opened: the record is a text beside
the body, and only data. Nothing in it is ever run.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..core.body.body import Body
from ..core.clip_files import signals_key
from ..core.file_names import shown
from ..core.patches.patches import PatchSet
from ..core.ranking.utility import UtilityMap
from ..core.results_folder import StudyResults
from .packing import pack, read_packed

RECORD = "W2W study"
"""Custom property of a body's mesh: the text that holds its study."""

LINE = 1000
"""Characters in a line of packed results: text editors choke on longer ones."""


@dataclass(frozen=True)
class StoredClip:
    """A clip of a run, its fields named as the panel's; of a skipped one only name, file and problem.

    `motion_key` is equal where clips show the same motion, `signals` is of `core.clip_files.signals_key`,
    and `action` the name of its action in the file.
    """

    name: str
    file: str
    activity: str = ""
    subject: str = ""
    n_frames: int = 0
    rate: float = 0.0
    skeleton: str = ""
    scale: float = 1.0
    motion_key: str = ""
    signals: str = ""
    action: str = ""
    problem: str = ""
    source_sha256: str = ""


@dataclass(frozen=True, eq=False)
class StudyRecord:
    """A finished run, as the panel shows it again.

    Parameters
    ----------
    parameters : dict
        The run's `StudyConfig` as plain values.
    clips : tuple of StoredClip
    patches : PatchSet
    utility : UtilityMap
    is_own_body : bool
        Whether the body is W2W's own in its average shape, so that its sliders fit it.
    collections : tuple of str
        Names of the collections of all patches and of the chosen ones.
    advice : dict
        Of the summary, what it says of sets of sensors; empty where it says nothing.
    """

    parameters: dict[str, Any]
    clips: tuple[StoredClip, ...]
    patches: PatchSet
    utility: UtilityMap
    is_own_body: bool = False
    collections: tuple[str, str] = ("", "")
    advice: dict[str, Any] = field(default_factory=dict)


def record_of(study: StudyResults, body: Body) -> StudyRecord:
    """The record of a results folder, without actions and collections.

    Raises
    ------
    ValueError
        If `summary.json` does not say what is needed of a clip.
    """
    own = Body.bundled()
    try:
        used = [
            StoredClip(
                name=entry["clip"],
                file=entry["file"],
                activity=entry["activity"],
                subject=entry["subject"],
                n_frames=entry["frames"],
                rate=entry["frame_rate"],
                skeleton=entry.get("skeleton", ""),
                scale=entry.get("scale", 1.0),
                motion_key=clip.motion_key,
                signals=signals_key(study.out, entry["clip"]),
                source_sha256=study.source_hashes.get(entry["file"], ""),
            )
            for entry, clip in zip(study.summary["used"], study.clips, strict=True)
        ]
    except KeyError as error:
        raise ValueError(
            f"{study.out}: summary.json does not say {error} of a clip: run the study again"
        ) from error
    skipped = [
        StoredClip(shown(Path(entry["file"]).name), entry["file"], problem=entry["reason"])
        for entry in study.summary.get("skipped", [])
    ]
    return StudyRecord(
        study.parameters,
        (*used, *skipped),
        study.patches,
        study.utility,
        body.vertices.shape == own.vertices.shape and np.allclose(body.vertices, own.vertices, atol=1e-6),
        advice={"worn_together": study.summary.get("worn_together")},
    )


def with_scene(
    record: StudyRecord, actions: Mapping[str, bpy.types.Action], collections: tuple[str, str]
) -> StudyRecord:
    """The record with what its clips and patches are called in the open file."""
    clips = tuple(
        replace(clip, action=actions[clip.name].name) if clip.name in actions else clip
        for clip in record.clips
    )
    return replace(record, clips=clips, collections=collections)


def write_record(mesh: bpy.types.Object, record: StudyRecord) -> None:
    """Put a record into the file, beside a body."""
    content = {
        "parameters": record.parameters,
        "clips": [asdict(clip) for clip in record.clips],
        "is_own_body": record.is_own_body,
        "collections": list(record.collections),
        "advice": record.advice,
        "patches": _lines(pack(record.patches)[0]),
        "utility": _lines(pack(record.utility)[0]),
    }
    text = bpy.data.texts.new(f"{RECORD}.json")
    text.from_string(json.dumps(content, indent=1))
    mesh[RECORD] = text


def has_record(mesh: bpy.types.Object) -> bool:
    """Whether a record lies beside a mesh."""
    return isinstance(mesh.get(RECORD), bpy.types.Text)


def read_record(mesh: bpy.types.Object) -> StudyRecord:
    """The record beside a mesh.

    Raises
    ------
    ValueError
        If it is damaged.
    """
    try:
        content = json.loads(mesh[RECORD].as_string())
        known = {item.name for item in fields(StoredClip)}
        clips = [{name: clip[name] for name in known & clip.keys()} for clip in content["clips"]]
        first, second = content["collections"]
        return StudyRecord(
            dict(content["parameters"]),
            tuple(StoredClip(**clip) for clip in clips),
            read_packed("".join(content["patches"]), PatchSet.load),
            read_packed("".join(content["utility"]), UtilityMap.load),
            bool(content["is_own_body"]),
            (str(first), str(second)),
            dict(content.get("advice", {})),
        )
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(f"what the file says of '{mesh.name}' is damaged: {error}") from error


def remove_record(mesh: bpy.types.Object) -> None:
    """Take the record away: what it said is now the panel's."""
    text = mesh[RECORD]
    del mesh[RECORD]
    bpy.data.texts.remove(text)


def _lines(text: str) -> list[str]:
    return [text[start : start + LINE] for start in range(0, len(text), LINE)]
