# SPDX-License-Identifier: GPL-3.0-or-later
"""The place of a clip's signals: in a results folder, or in the cache under a key of their content.

The cache folder is laid out as a results folder. Equal content has an equal key, whichever study it is of, so
undo and files saved under another name find theirs.
"""

import time
from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np

from ...core.files import load_arrays
from ...core.given import ForeignFileError
from ...core.imu.recording import ImuRecording
from ...core.study.clip_files import STORED, Windows, features_file, signals_file, signals_key
from ...core.study.results import stored_recording
from ..jobs.preferences import SIGNALS_SUFFIX, cache_folder

Place = tuple[Path, str]
"""Folder of a clip's files, and their name there."""

LOOK = 2.0
"""Seconds for which panels do not look at the disk again."""

KEPT = 4
"""Recordings kept in memory for the overlay."""

_recordings: OrderedDict[str, ImuRecording] = OrderedDict()
_looks: dict[tuple[str, str], tuple[float, bool]] = {}


def place_of(clip: bpy.types.PropertyGroup) -> Place:
    """Folder of a clip's files and their name there."""
    folder = clip.id_data.w2w.results_folder
    if folder and clip.signals.startswith(STORED):
        return Path(folder), clip.stored_as
    return cache_folder(), clip.signals + SIGNALS_SUFFIX


def places_of(clips: Sequence[bpy.types.PropertyGroup]) -> list[Place]:
    """The places of the files of baked clips.

    Raises
    ------
    ValueError
        If some are not there any more.
    """
    lost = [clip.name for clip in clips if not has(clip)]
    if lost:
        raise ValueError(
            f"The signals of {len(lost)} clips are gone ({lost[0]}): bake them first (page Details)"
        )
    return [place_of(clip) for clip in clips]


def has(clip: bpy.types.PropertyGroup) -> bool:
    """Whether a clip's signals are there; a run may have replaced its own since."""
    place = place_of(clip)
    try:
        if clip.signals.startswith(STORED):
            return signals_key(*place) == clip.signals
        return bool(clip.signals) and all(file(*place).is_file() for file in (signals_file, features_file))
    except ForeignFileError:  # a .blend file may say anything
        return False


def is_lost(clip: bpy.types.PropertyGroup) -> bool:
    """Whether a clip's signals are gone, as of `LOOK` seconds ago: panels ask at every drawing."""
    key, now = (clip.id_data.w2w.results_folder, clip.signals), time.monotonic()
    if key not in _looks or now - _looks[key][0] > LOOK:
        _looks[key] = now, not has(clip)
    return _looks[key][1]


def with_added(place: Place, added: ImuRecording, windows: Windows) -> tuple[ImuRecording, Windows]:
    """A clip's signals and windows, with those of patches that were appended."""
    before = load_arrays(features_file(*place), ("features",), "does not hold a clip's windows")["features"]
    features = np.concatenate([before, windows[0]], axis=1)
    return stored_recording(*place).with_sensors_of(added), (features, windows[1])


def recording(clip: bpy.types.PropertyGroup) -> ImuRecording | None:
    """The recording of a clip, or None if it is not on disk (any more)."""
    if clip.signals not in _recordings:
        try:
            (place,) = places_of([clip])
            _recordings[clip.signals] = stored_recording(*place)
        except (OSError, ValueError):  # damaged is as good as gone: baked again
            return None
        while len(_recordings) > KEPT:
            _recordings.popitem(last=False)
    _recordings.move_to_end(clip.signals)
    return _recordings[clip.signals]
