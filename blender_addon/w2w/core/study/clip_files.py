# SPDX-License-Identifier: GPL-3.0-or-later
"""The clips of a results folder: the files that the ranking reads, and the list of those used and skipped."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any
from zipfile import ZipFile

import numpy as np

from ..files import DAMAGED, atomic_write, load_arrays, write_npz, write_text
from ..given import checked, inside
from ..imu.recording import ImuRecording
from ..library.library import WORK_FOLDER
from ..ranking.utility import inputs_of
from ..windows.inputs import FeatureFiles, PatchBlocks, WindowFiles
from ..windows.windows import WindowSpec

WORK = WORK_FOLDER
"""Folder inside the output folder for what a later run can take up again."""


CHANGING = f"{WORK}/changing"
"""A file that is there while results are replaced: those that lie there may be of two studies."""


def mark_changing(out: Path, by: str = "run") -> None:
    """Say, before the first file of a results folder changes, that its results do not belong together now.

    `by` is the command that changes it, and can be given again.
    """
    if not (mark := inside(out, CHANGING)).exists():
        write_text(mark, by)


def mark_whole(out: Path) -> None:
    """Say, after the last file has changed, that the results of a folder belong together."""
    inside(out, CHANGING).unlink(missing_ok=True)


MANY_CLIPS = 4096
"""Number of clips above which a new results folder divides them among sub-folders."""

SUBFOLDERS = tuple(f"{number:02x}" for number in range(256))
"""Names of the sub-folders: with a million clips, each holds four thousand."""


def divide(folder: Path) -> None:
    """Make the sub-folders of a folder of clips' files, unless files lie in it already."""
    with os.scandir(folder) as entries:
        if all(entry.is_dir() for entry in entries):
            for name in SUBFOLDERS:
                (folder / name).mkdir(exist_ok=True)


def _file_of(out: Path, folder: str, clip: str) -> Path:
    """A clip's file, in the sub-folder given by a hash of the clip's name, if the folder is divided."""
    part = f"{folder}/{hashlib.sha256(clip.encode('utf-8', 'replace')).hexdigest()[:2]}"
    is_divided = os.path.isdir(f"{out}/{part}")  # noqa: PTH112 - a path's own call costs more
    return inside(out, f"{part if is_divided else folder}/{clip}.npz")


def motion_file(out: Path, clip: str) -> Path:
    """The motion of a clip on the study's body."""
    return _file_of(out, "motions", clip)


def signals_file(out: Path, clip: str) -> Path:
    """The recording of all patches of a clip."""
    return _file_of(out, "signals", clip)


def features_file(out: Path, clip: str) -> Path:
    """Windows of a clip as features."""
    return _file_of(out, f"{WORK}/features", clip)


def write_features(path: Path, features: np.ndarray, is_test: np.ndarray, signature: np.ndarray) -> None:
    """Write the features of a clip, shape (windows, N, D), and the mask of test windows.

    Equal motions have equal signatures.
    """
    write_npz(path, {"features": features, "is_test": is_test, "signature": signature})


Windows = tuple[np.ndarray, np.ndarray]
"""Windows of a clip as features, and the mask of test windows."""


def write_clip(
    out: Path, clip: str, recording: ImuRecording, windows: Windows, signature: np.ndarray
) -> None:
    """Write the signals and the windows of a clip into a folder laid out as a results folder."""
    for path in (signals_file(out, clip), features_file(out, clip)):
        path.parent.mkdir(parents=True, exist_ok=True)
    write_features(features_file(out, clip), *windows, signature)
    recording.save(signals_file(out, clip))


@dataclass(frozen=True, eq=False, slots=True)
class ClipWindows:
    """What the ranking needs of a clip's windows besides their signals."""

    is_test: np.ndarray
    """Test windows, shape (W,), bool."""
    signature: np.ndarray
    """`motion_signature`: equal for equal motions."""
    file: Path | None = None
    """The file that they were read from, with their features."""

    @classmethod
    def read(cls, out: Path, clip: str) -> ClipWindows:
        """The windows of a clip of a run."""
        file, needed = features_file(out, clip), ("is_test", "signature")
        return cls(**load_arrays(file, needed, "does not hold a clip's windows"), file=file)


NO_SIGNATURE = np.empty(0, dtype=np.float16)


class Signatures(Sequence[np.ndarray]):
    """Signatures of clips in a temporary file, because those of 100,000 clips would take 0.5 GB of memory."""

    def __init__(self, folder: Path) -> None:
        self._file = TemporaryFile(dir=folder)  # noqa: SIM115 - closed with this
        self._ends = [0]

    def append(self, signature: np.ndarray) -> None:
        """Add the next clip's signature, shape (K,), in half precision."""
        self._file.seek(self._ends[-1])
        self._file.write(signature.astype(np.float16, copy=False).tobytes())
        self._ends.append(self._file.tell())

    def __len__(self) -> int:
        return len(self._ends) - 1

    def __getitem__(self, clip: int) -> np.ndarray:  # type: ignore[override]  # no slices
        first, last = self._ends[range(len(self))[clip]], self._ends[clip + 1]
        self._file.seek(first)
        return np.frombuffer(self._file.read(last - first), dtype=np.float16)

    def close(self) -> None:
        """Close and remove the file."""
        self._file.close()


def ranking_inputs(
    clips: Sequence[tuple[Path, str]], windows: Sequence[ClipWindows], classifier: str, spec: WindowSpec
) -> PatchBlocks:
    """A classifier's inputs from clips, given by folder and name, read from disk."""
    if inputs_of(classifier) == "features":
        pairs = zip(clips, windows, strict=True)
        return FeatureFiles([of_clip.file or features_file(*clip) for clip, of_clip in pairs])
    return WindowFiles(
        [signals_file(*clip) for clip in clips], [len(of_clip.is_test) for of_clip in windows], spec
    )


@dataclass(frozen=True, eq=False)
class FilesToRank:
    """The content of a study's clip files for the ranking by a classifier."""

    windows: tuple[ClipWindows, ...]
    inputs: PatchBlocks
    classifier: str


STORED = "run-"
"""Prefix of keys of signals in a results folder."""


def signals_key(out: Path, clip: str) -> str:
    """A key of a clip's windows and of its signals, if these are kept; "" if they cannot be read.

    Raises ForeignFileError if they lie elsewhere. The key is made of the checksums that an npz file
    keeps of its arrays, which are not read themselves.
    """
    digest, signals, features = hashlib.sha256(), signals_file(out, clip), features_file(out, clip)
    try:
        for path in (*([signals] if signals.exists() else ()), features):
            with ZipFile(path) as archive:
                for member in archive.infolist():
                    digest.update(f"{member.filename} {member.file_size} {member.CRC}\n".encode())
    except (OSError, ValueError, *DAMAGED):
        return ""
    return STORED + digest.hexdigest()[:32]


CLIP_LIST = "clips.jsonl"

Entry = dict[str, Any]


def write_clip_list(out: Path, entries: Iterable[Entry]) -> None:
    """Write the list into a results folder, whole or not at all."""
    with atomic_write(out / CLIP_LIST) as stream:
        for entry in entries:
            line = json.dumps(entry, ensure_ascii=False, allow_nan=False) + "\n"
            stream.write(line.encode("utf-8", "backslashreplace"))


def read_clip_list(out: Path) -> Iterator[Entry]:
    """Each clip of a results folder; ValueError if the list is damaged or names a file elsewhere."""
    path = inside(out, CLIP_LIST)
    with path.open(encoding="utf-8") as stream:
        for number, line in enumerate(stream, start=1):
            entry = json.loads(line)
            if not isinstance(entry, dict) or not isinstance(entry.get("file"), str):
                raise ValueError(f"{CLIP_LIST} is damaged: line {number} names no file")
            if "clip" in entry:
                checked(entry["clip"], f"{path}, line {number},")
            yield entry


def is_used(entry: Entry) -> bool:
    """Whether the clip was turned into signals; others have the reason under `skipped`."""
    return "skipped" not in entry
