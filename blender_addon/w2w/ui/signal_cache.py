# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked signals on disk, under keys of everything they were made from, so that no study gets another's."""

from __future__ import annotations

from collections import OrderedDict
from pathlib import Path

import numpy as np

from ..core.clip_files import ClipWindows
from ..core.files import load_arrays, write_npz
from ..core.imu.recording import ImuRecording
from .preferences import cache_folder

KEPT = 4
"""Recordings kept in memory for the overlay."""


_recordings: OrderedDict[str, ImuRecording | None] = OrderedDict()


def path_of(key: str, folder: Path | None = None) -> Path:
    """File of a key, in the cache folder by default; a thread must be told, for that asks bpy."""
    return (folder or cache_folder()) / f"{key}.w2w.npz"


def has(key: str) -> bool:
    """Whether a key's signals are there."""
    return bool(key) and path_of(key).is_file()


def save(key: str, recording: ImuRecording, features: np.ndarray, windows: ClipWindows, folder: Path) -> None:
    """Keep a baked clip, its features of shape (W, N, D); safe in a thread."""
    write_npz(
        path_of(key, folder),
        {
            "acc": recording.acc,
            "gyr": recording.gyr,
            "rate": np.array(recording.rate),
            "features": features,
            "is_test": windows.is_test,
            "signature": windows.signature,
        },
    )
    _recordings.pop(key, None)


def windows_of(key: str) -> ClipWindows:
    """Windows of a key."""
    data = load_arrays(path_of(key), ("is_test", "signature"), "does not hold baked signals")
    return ClipWindows(data["is_test"], data["signature"], (len(data["is_test"]),))


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
        data = load_arrays(path_of(key), ("acc", "gyr", "rate"), "does not hold baked signals")
    except (OSError, ValueError):  # damaged is as good as gone: baked again
        return None
    return ImuRecording(data["acc"], data["gyr"], float(data["rate"]))
