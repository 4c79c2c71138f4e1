# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's .blend file holds the small files of its results folder for W2W's panel, packed as text.

The extension need not be there when the file is written, nor when it is opened: the record is a text beside
the body, and only data. Nothing in it is ever run.
"""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import bpy

from ...core.clip_files import WORK, signals_key
from ...core.files import DAMAGED
from ...core.results_folder import UTILITY, StudyResults
from .packing import MOST_PACKED

RECORD = "W2W study"
"""Custom property of a body's mesh: the text that holds its study."""

FILES = ("summary.json", "config.json", UTILITY, f"{WORK}/patches.npz")
"""Files of a results folder that the record holds."""

NAMES = "names.json"


@dataclass(frozen=True)
class SceneNames:
    """Names in a run's .blend file: collections of all patches and of the chosen ones, each clip's action.

    Each clip's signals are known by the key of `core.clip_files.signals_key`.
    """

    collections: tuple[str, str]
    actions: Mapping[str, str]
    signals: Mapping[str, str]


def keys_of(study: StudyResults) -> dict[str, str]:
    """By which the stored signals of each clip are known again."""
    return {clip.name: signals_key(study.out, clip.name) for clip in study.clips}


def write_record(
    mesh: bpy.types.Object,
    study: StudyResults,
    collections: tuple[str, str],
    actions: Mapping[str, bpy.types.Action],
) -> None:
    """Put the record of a results folder into the open file, beside a body."""
    names = {clip: action.name for clip, action in actions.items()}
    packed = io.BytesIO()
    with ZipFile(packed, "w", ZIP_DEFLATED) as archive:
        for name in FILES:
            archive.writestr(ZipInfo(name), (study.out / name).read_bytes(), ZIP_DEFLATED)
        content = {"collections": collections, "actions": names, "signals": keys_of(study)}
        archive.writestr(ZipInfo(NAMES), json.dumps(content), ZIP_DEFLATED)
    text = bpy.data.texts.new(RECORD)
    text.from_string(base64.encodebytes(packed.getvalue()).decode("ascii"))
    mesh[RECORD] = text


def has_record(mesh: bpy.types.Object) -> bool:
    """Whether a record lies beside a mesh."""
    return isinstance(mesh.get(RECORD), bpy.types.Text)


def read_record(mesh: bpy.types.Object) -> tuple[StudyResults, SceneNames]:
    """The study that a record holds, without large files, and names in the file; ValueError if damaged."""
    try:
        packed = base64.b64decode(mesh[RECORD].as_string())
        with ZipFile(io.BytesIO(packed)) as archive, TemporaryDirectory() as folder:
            if sum(archive.getinfo(name).file_size for name in (*FILES, NAMES)) > MOST_PACKED:
                raise ValueError("it unpacks to too much")
            for name in FILES:  # no other: a file's word leads nowhere
                archive.extract(name, folder)
            study = StudyResults.load(Path(folder))
            study.summary, study.source_hashes  # noqa: B018 - kept, for the folder does not stay
            names = SceneNames(**json.loads(archive.read(NAMES)))
            first, second = map(str, names.collections)
            actions, signals = (
                {str(clip): str(name) for clip, name in part.items()}
                for part in (names.actions, names.signals)
            )
            return study, SceneNames((first, second), actions, signals)
    except (ValueError, AttributeError, RecursionError, OSError, *DAMAGED) as error:
        raise ValueError(f"what the file says of '{mesh.name}' is damaged: {error}") from error


def remove_record(mesh: bpy.types.Object) -> None:
    """Take the record away: what it said is now the panel's."""
    text = mesh[RECORD]
    del mesh[RECORD]
    bpy.data.texts.remove(text)
