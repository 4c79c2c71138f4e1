# SPDX-License-Identifier: GPL-3.0-or-later
"""The clips of a finished run as rows of the panel's list."""

import json
from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import Any

from ..study.clip_files import CLIP_LIST, Entry, is_used
from ..study.results import StudyResults
from ..wording import clean
from .cautions import ODD

KEPT = {*ODD, "source", "cloth_frames"}
"""Facts of a clip that it keeps without a property of its own."""

GONE = "its motion is no longer where the run left it"
UNHELD = "its motion is not in this file, which holds three an activity: 'Open Results' has all"


def clips_of(
    run: StudyResults, signals: Mapping[str, str], actions: Mapping[str, object]
) -> list[dict[str, Any]]:
    """The clips of a run by the panel's properties, those that could not be used last.

    `signals` are keys and `actions` Blender's actions, None for a lost one, by the clips' names. ValueError
    if the run's list does not say what is needed of a clip.
    """
    held = {clip: "" if action is not None else GONE for clip, action in actions.items()}
    try:
        used = [
            {
                "action": actions.get(clip.name),  # before its activity, which is noted on it
                **vars(clip),
                "file": _shown_file(entry),
                "n_frames": int(entry["frames"]),
                "rate": float(entry["frame_rate"]),
                "skeleton": str(entry.get("skeleton", "")),
                "scale": float(entry.get("scale", 1.0)),
                "signals": signals.get(clip.name, ""),
                "stored_as": clip.name,
                "problem": held.get(clip.name, UNHELD),
                "source_sha256": str(entry.get("sha256", "")),
                "facts": json.dumps({name: entry[name] for name in KEPT & entry.keys()}),
            }
            for entry, clip in zip(filter(is_used, run.entries), run.clips, strict=True)
        ]
    except KeyError as error:
        reason = f"{run.out}: {CLIP_LIST} does not say {error} of a clip: run the study again"
        raise ValueError(reason) from error
    except (TypeError, ValueError) as error:
        raise ValueError(f"{run.out}: what {CLIP_LIST} says of clips is damaged: {error}") from error
    skipped = [(_shown_file(entry), entry["skipped"]) for entry in run.entries if not is_used(entry)]
    return used + [{"name": clean(Path(file).name), "file": file, "problem": why} for file, why in skipped]


def _shown_file(entry: Entry) -> str:
    """The file of a clip, to show and never to open: the run does not name its library."""
    file = PurePath(entry["file"])
    return file.name if file.is_absolute() else entry["file"]
