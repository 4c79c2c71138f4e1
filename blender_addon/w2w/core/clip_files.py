# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that the work on a clip leaves for the ranking: its windows and those of its copies."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from zipfile import ZipFile

import numpy as np

from .files import DAMAGED, load_arrays, write_npz
from .motion.library import WORK_FOLDER
from .ranking.inputs import FeatureFiles, PatchBlocks, WindowFiles
from .ranking.utility import inputs_of
from .ranking.windows import WindowSpec

WORK = WORK_FOLDER
"""Folder inside the output folder for what a later run can take up again."""


def motion_file(out: Path, clip: str) -> Path:
    """The motion of a clip on the study's body."""
    return out / "motions" / f"{clip}.npz"


def signals_file(out: Path, clip: str) -> Path:
    """The recording of all patches of a clip."""
    return out / "signals" / f"{clip}.npz"


def features_file(out: Path, clip: str) -> Path:
    """Windows of a clip, then of its copies, as features."""
    return out / WORK / "features" / f"{clip}.npz"


def copy_file(out: Path, clip: str, copy: int) -> Path:
    """The recording of a copy of a clip, where the classifier needs it."""
    return out / WORK / "copies" / f"{clip}.{copy}.npz"


def write_features(
    path: Path, features: Sequence[np.ndarray], is_test: np.ndarray, signature: np.ndarray
) -> None:
    """Write the features of a clip and then of each copy, each of shape (windows, N, D).

    `is_test` is of the clip's own windows, as copies are never tested; equal motions have equal signatures.
    """
    counts = np.array([len(part) for part in features])
    whole = np.zeros(counts.sum(), dtype=bool)
    whole[: len(is_test)] = is_test
    arrays = {"features": np.concatenate(features), "is_test": whole}
    write_npz(path, arrays | {"signature": signature, "counts": counts})


@dataclass(frozen=True, eq=False)
class ClipWindows:
    """What the ranking must know of a clip's windows beside their signals."""

    is_test: np.ndarray
    """Windows that may be tested on, shape (W,), bool."""
    signature: np.ndarray
    """`motion_signature`: equal for equal motions."""
    counts: tuple[int, ...]
    """Windows of the clip, then of each copy."""

    @classmethod
    def read(cls, out: Path, clip: str) -> ClipWindows:
        """Those of a run's clip."""
        needed = ("is_test", "signature", "counts")
        data = load_arrays(features_file(out, clip), needed, "does not hold a clip's windows")
        return cls(data["is_test"], data["signature"], tuple(data["counts"].tolist()))


def recordings_of(out: Path, clip: str, windows: ClipWindows) -> list[Path]:
    """The recording of a clip, then those of its copies, which may not have been kept."""
    copies = range(len(windows.counts) - 1)
    return [signals_file(out, clip), *(copy_file(out, clip, copy) for copy in copies)]


def ranking_inputs(
    clips: Sequence[tuple[Path, str]], windows: Sequence[ClipWindows], classifier: str, spec: WindowSpec
) -> PatchBlocks:
    """A classifier's inputs from clips, given by folder and name, and their copies, read from disk."""
    if inputs_of(classifier) == "features":
        return FeatureFiles([features_file(*clip) for clip in clips])
    recordings = [
        path for clip, found in zip(clips, windows, strict=True) for path in recordings_of(*clip, found)
    ]
    return WindowFiles(recordings, [count for found in windows for count in found.counts], spec)


STORED = "run-"
"""Prefix of keys of signals in a results folder."""


def signals_key(out: Path, clip: str) -> str:
    """A key of a clip's windows and of its signals, where these are kept; empty where they cannot be read.

    It is made of the checksums that an npz file keeps of its arrays, which are not read themselves.
    """
    digest, signals = hashlib.sha256(), signals_file(out, clip)
    try:
        for path in (*([signals] if signals.exists() else ()), features_file(out, clip)):
            with ZipFile(path) as archive:
                for member in archive.infolist():
                    digest.update(f"{member.filename} {member.file_size} {member.CRC}\n".encode())
    except (OSError, ValueError, *DAMAGED):
        return ""
    return STORED + digest.hexdigest()[:32]
