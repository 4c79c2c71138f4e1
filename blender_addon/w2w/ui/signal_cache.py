# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked signals on disk, under keys of everything they were made from, so that no study gets another's.

They lie in the cache folder, or where a run has stored them: in its results folder.
"""

from __future__ import annotations

from collections import OrderedDict
from pathlib import Path

import numpy as np

from ..core.clip_files import ClipWindows, copy_file, features_file, signals_file, signals_key
from ..core.files import load_arrays, write_npz
from ..core.findings.new_folder import recording_of
from ..core.imu.recording import ImuRecording
from .preferences import cache_folder

KEPT = 4
"""Recordings kept in memory for the overlay."""


_recordings: OrderedDict[str, ImuRecording | None] = OrderedDict()

_linked: dict[str, tuple[Path, str]] = {}
"""Results folder, and name of the clip in it, of keys that a run has stored."""


def link(key: str, results: Path, clip: str) -> None:
    """Look for a key's signals in a results folder from now on."""
    _linked[key] = (results, clip)
    _recordings.pop(key, None)


def path_of(key: str, folder: Path | None = None) -> Path:
    """File of a key's features, in the cache folder by default; a thread must be told, for that asks bpy."""
    if key in _linked:
        return features_file(*_linked[key])
    return (folder or cache_folder()) / f"{key}.w2w.npz"


def recordings_of(key: str, windows: ClipWindows | None = None) -> list[Path]:
    """Files with a key's signals: the clip's own and, where its windows are given, those of its copies."""
    if key not in _linked:
        return [path_of(key)]
    copies = range(len(windows.counts) - 1 if windows is not None else 0)
    return [signals_file(*_linked[key]), *(copy_file(*_linked[key], copy) for copy in copies)]


def has(key: str) -> bool:
    """Whether a key's signals are there; those of a run may have been made anew since."""
    if key in _linked:
        return signals_key(*_linked[key]) == key
    return bool(key) and path_of(key).is_file()


def save(key: str, recording: ImuRecording, features: np.ndarray, windows: ClipWindows, folder: Path) -> None:
    """Keep a baked clip, its features of shape (W, N, D); safe in a thread."""
    write_npz(
        path_of(key, folder),
        {
            "acc": recording.acc,
            "gyr": recording.gyr,
            "rate": np.array(recording.rate),
            **recording.further,
            "features": features,
            "is_test": windows.is_test,
            "signature": windows.signature,
        },
    )
    _recordings.pop(key, None)


def windows_of(key: str) -> ClipWindows:
    """Windows of a key."""
    needed = ("is_test", "signature")
    data = load_arrays(path_of(key), needed, "does not hold baked signals", ("counts",))
    counts = data.get("counts", np.array([len(data["is_test"])]))
    return ClipWindows(data["is_test"], data["signature"], tuple(counts.tolist()))


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
        return recording_of(recordings_of(key)[0])
    except (OSError, ValueError):  # damaged is as good as gone: baked again
        return None
