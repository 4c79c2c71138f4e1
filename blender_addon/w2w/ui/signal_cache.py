# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked signals on disk, under keys of everything they were made from, so that no study gets another's.

They lie in a folder laid out as a results folder: in the cache folder, or where a run has stored them.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np

from ..core.clip_files import features_file, signals_file, signals_key, write_features
from ..core.imu.recording import ImuRecording
from .preferences import SIGNALS_SUFFIX, cache_folder

KEPT = 4
"""Recordings kept in memory for the overlay."""


_recordings: OrderedDict[str, ImuRecording | None] = OrderedDict()

_linked: dict[str, tuple[Path, str]] = {}
"""Results folder, and name of the clip in it, of keys that a run has stored."""


def link(key: str, results: Path, clip: str) -> None:
    """Look for a key's signals in a results folder from now on."""
    _linked[key] = (results, clip)
    _recordings.pop(key, None)


def place_of(key: str, folder: Path | None = None) -> tuple[Path, str]:
    """Folder of a key's files and their name there; a thread must be told the cache folder."""
    return _linked.get(key) or (folder or cache_folder(), key + SIGNALS_SUFFIX)


def places_of(clips: Sequence[bpy.types.PropertyGroup]) -> list[tuple[Path, str]]:
    """Where the files of baked clips are.

    Raises
    ------
    ValueError
        If some are not there any more.
    """
    lost = [clip.name for clip in clips if not has(clip.signals)]
    if lost:
        raise ValueError(f"The signals of {len(lost)} clips are gone ({lost[0]}): bake them first (step 4)")
    return [place_of(clip.signals) for clip in clips]


def has(key: str) -> bool:
    """Whether a key's signals are there; those of a run may have been made anew since."""
    if key in _linked:
        return signals_key(*_linked[key]) == key
    return bool(key) and all(file(*place_of(key)).is_file() for file in (signals_file, features_file))


def save(
    key: str,
    recording: ImuRecording,
    windows: tuple[np.ndarray, np.ndarray],
    signature: np.ndarray,
    folder: Path,
) -> None:
    """Keep a baked clip with its windows, as features and whether each may be tested on; safe in a thread."""
    place, (features, is_test) = place_of(key, folder), windows
    for path in (signals_file(*place), features_file(*place)):
        path.parent.mkdir(parents=True, exist_ok=True)
    write_features(features_file(*place), [features], is_test, signature)
    recording.save(signals_file(*place))
    _recordings.pop(key, None)


def recording(key: str) -> ImuRecording | None:
    """Recording of a key, or None where it is not in the cache (any more)."""
    if key not in _recordings:
        _recordings[key] = _load_recording(key)
        while len(_recordings) > KEPT:
            _recordings.popitem(last=False)
    _recordings.move_to_end(key)
    return _recordings[key]


def forget() -> None:
    """Look at the disk again."""
    _recordings.clear()


def _load_recording(key: str) -> ImuRecording | None:
    if not has(key):
        return None
    try:
        return ImuRecording.load(signals_file(*place_of(key)))
    except (OSError, ValueError):  # damaged is as good as gone: baked again
        return None
