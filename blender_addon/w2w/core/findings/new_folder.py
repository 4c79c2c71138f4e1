# SPDX-License-Identifier: GPL-3.0-or-later
"""A results folder of a study that no run has made: from its parts, as `w2w run` would have left it."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..body.body import Body
from ..clip_files import (
    WORK,
    ClipWindows,
    copy_file,
    features_file,
    motion_file,
    ranking_inputs,
    recordings_of,
    signals_file,
)
from ..clip_ranking import LabelledClip, rank_clips, same_motions
from ..files import UNFINISHED, write_json
from ..garments.cover import FITTED, Cover, save_covers
from ..imu.recording import ImuRecording
from ..motion.library import Clip, Library
from ..motion.motion import Motion
from ..patches.patches import PatchSet
from ..ranking.pooling import Pooling
from ..ranking.utility import UtilityMap
from ..results_folder import StudyResults, choose_to_wear, prepared_tests
from ..study import StudyConfig
from .finished_study import ClipResult, Study
from .summary import config_content, write_results

FOLDERS = ("motions", "signals", f"{WORK}/features", f"{WORK}/copies")


@dataclass(frozen=True, eq=False)
class SavedClip:
    """A clip and where its parts are.

    Parameters
    ----------
    clip : Clip
        Its name is that of its files.
    motion : Motion or None
        None where no motion tells what moved the body.
    place : tuple of Path and str
        Folder that its signals and windows are in, laid out as a results folder, and their name there.
    details : dict
        What the summary is to say of it, beside its windows.
    source_sha256 : str
        Hash of the file that it was read from; empty where there is none.
    """

    clip: Clip
    motion: Motion | None
    place: tuple[Path, str]
    details: dict[str, Any]
    source_sha256: str


@dataclass(frozen=True, eq=False)
class StudyParts:
    """All that a results folder is made of.

    Parameters
    ----------
    config : StudyConfig
    body : Body
    patches : PatchSet
    clips : tuple of SavedClip
    utility : UtilityMap or None
        The ranking of these clips; None where they are to be ranked.
    library : Library
        The clips again, and what was left out.
    covers : mapping of str to Cover
        What each garment of the config covers.
    """

    config: StudyConfig
    body: Body
    patches: PatchSet
    clips: tuple[SavedClip, ...]
    utility: UtilityMap | None
    library: Library
    covers: Mapping[str, Cover] = field(default_factory=dict)


def write_folder(folder: Path, parts: StudyParts, told: Callable[[float], None]) -> None:
    """Write a results folder, whole or not at all.

    Parameters
    ----------
    folder : Path
        New, or empty.
    parts : StudyParts
    told : callable
        Given the fraction done; what it raises ends the work.

    Raises
    ------
    ValueError
        If the folder is not empty, the clips cannot be ranked, or the constraints not be met.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ValueError(f"{folder} is not empty: choose a new folder for the results")
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(
        dir=folder.parent, prefix=f".{folder.name[:40]}.", suffix=UNFINISHED
    ) as temporary:
        out = Path(temporary) / "results"
        _write(out, parts, told)
        if folder.exists():
            folder.rmdir()
        out.replace(folder)


def _write(out: Path, parts: StudyParts, told: Callable[[float], None]) -> None:
    for name in FOLDERS:
        (out / name).mkdir(parents=True)
    parts.body.save(out / WORK / "body.npz")
    parts.patches.save(out / WORK / "patches.npz")
    if parts.covers:
        save_covers(out / FITTED, parts.covers, [""] * len(parts.covers))
    results = []
    for number, saved in enumerate(parts.clips):
        told(0.4 * number / len(parts.clips))
        results.append(_write_clip(out, saved, parts.patches))
    pooling = Pooling.on(parts.body, parts.patches)
    utility, ranked = _ranked(out, parts, pooling, told)
    told(0.8)
    config = parts.config
    study = StudyResults(out, utility, parts.patches, ranked, config.as_dict())
    told(0.85)
    advice = choose_to_wear(utility, parts.patches, config, prepared_tests(study, config, pooling))
    finished = Study(parts.library, config, parts.body, tuple(results), study, advice)
    write_json(out / "config.json", config_content(finished))
    write_results(finished)


def _write_clip(out: Path, saved: SavedClip, patches: PatchSet) -> ClipResult:
    clip = saved.clip
    if saved.motion is not None:
        saved.motion.save(motion_file(out, clip.name))
    labels = (clip.activity, clip.subject, clip.name)
    recording = ImuRecording.load(signals_file(*saved.place))
    recording.labelled(patches.names, *labels).save(signals_file(out, clip.name))
    shutil.copyfile(features_file(*saved.place), features_file(out, clip.name))
    windows = ClipWindows.read(out, clip.name)
    copies = recordings_of(*saved.place, windows)[1:]
    for number, copy in enumerate(path for path in copies if path.is_file()):
        shutil.copyfile(copy, copy_file(out, clip.name, number))
    details = {"windows": windows.counts[0], "test_windows": int(windows.is_test.sum())}
    return ClipResult(clip, "", {**saved.details, **details}, saved.source_sha256)


def _ranked(
    out: Path, parts: StudyParts, pooling: Pooling, told: Callable[[float], None]
) -> tuple[UtilityMap, tuple[LabelledClip, ...]]:
    """The ranking and its clips, made anew where it is not of these clips."""
    clips = [saved.clip for saved in parts.clips]
    places = [(out, clip.name) for clip in clips]
    windows = [ClipWindows.read(*place) for place in places]
    if parts.utility is not None:
        return parts.utility, same_motions(clips, windows)
    config = parts.config
    inputs = ranking_inputs(places, windows, config.classifier, config.windows)
    return rank_clips(clips, windows, inputs, config, lambda done: told(0.4 + 0.4 * done), pooling=pooling)
