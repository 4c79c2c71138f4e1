# SPDX-License-Identifier: GPL-3.0-or-later
"""Features or windows of a whole library, from its clips' files some patches at a time, or of recordings."""

import math
import struct
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple, Protocol, runtime_checkable
from zipfile import ZIP_STORED, ZipFile

import numpy as np

from ..files import DAMAGED, load_arrays, read_header, stamp
from ..imu.recording import ImuRecording
from ..threads import chunks
from ..wording import restated
from .features import window_features
from .windows import TooShortError, WindowSpec, cut_windows, window_starts

ITEM_BYTES = np.dtype(np.float32).itemsize

KEPT = 4096
"""Arrays whose places are kept: each time that a choice reads the clips, finding them took a third of it."""

LOCAL_HEADER = struct.Struct("<26x2H")
"""Start of a zip member: after 26 bytes come the lengths of its name and of its extra field."""


@dataclass(frozen=True, slots=True)
class StoredArray:
    """The place of an array (W, N, D), float32, in a file."""

    path: Path
    offset: int  # byte of its first value
    shape: tuple[int, ...]

    @staticmethod
    def find(path: Path, name: str) -> "StoredArray":
        """Find an array that `files.write_npz` wrote; a ValueError if it holds none, or compresses it."""
        return _found(path, name, tuple(stamp(path)))

    def columns(self, runs: Sequence[tuple[int, int]]) -> np.ndarray:
        """A copy of the columns in these runs, end exclusive."""
        part = np.empty((self.shape[0], sum(last - first for first, last in runs), self.shape[2]), np.float32)
        self.read_columns(runs, np.arange(len(part)), part)
        return part

    def some(self, columns: Sequence[int]) -> np.ndarray:
        """A copy of some columns, of all rows: of many rows all are read, and no sum is checked."""
        whole = np.fromfile(self.path, np.float32, math.prod(self.shape), offset=self.offset)
        if whole.size < math.prod(self.shape):
            raise ValueError(f"{self.path} was cut short")
        return whole.reshape(self.shape)[:, list(columns)]

    def read_columns(self, runs: Sequence[tuple[int, int]], rows: np.ndarray, part: np.ndarray) -> None:
        """Fill `part` (V, P, D), contiguous, with some rows of the P columns in these runs, end exclusive."""
        value_bytes = self.shape[2] * ITEM_BYTES
        with open(self.path, "rb", buffering=0) as stream:  # noqa: PTH123 - Path.open takes 9 microseconds more
            for row, values in zip(rows.tolist(), part, strict=True):
                place = 0
                for first, last in runs:
                    some = values[place : (place := place + last - first)]
                    stream.seek(self.offset + (row * self.shape[1] + first) * value_bytes)
                    if stream.readinto(some) != some.nbytes:
                        raise ValueError(f"{self.path} was cut short")


@lru_cache(maxsize=KEPT)
def _found(path: Path, name: str, _stamp: tuple[int, ...]) -> StoredArray:
    with restated(f"{path} does not hold the array '{name}'", DAMAGED), ZipFile(path) as archive:
        info = archive.getinfo(f"{name}.npy")
        if info.compress_type != ZIP_STORED:
            raise ValueError(f"{path}: '{name}' is compressed and cannot be read in parts")
        with path.open("rb") as stream:
            stream.seek(info.header_offset)
            stream.seek(sum(LOCAL_HEADER.unpack(stream.read(LOCAL_HEADER.size))), 1)
            shape, is_fortran, dtype = read_header(stream)
            offset = stream.tell()
    held = offset + math.prod(shape) * dtype.itemsize <= path.stat().st_size
    if is_fortran or dtype != np.float32 or len(shape) != 3 or 0 in shape or not held:
        raise ValueError(f"{path}: '{name}' is not an array that W2W wrote")
    return StoredArray(path, offset, shape)


BLOCK_BYTES = 256 * 2**20
"""Memory for the patches held at a time."""

Which = slice | list[int] | np.ndarray
"""Some patches, by their numbers."""


@runtime_checkable
class PatchBlocks(Protocol):
    """Inputs of classifiers: W windows of N patches, in single precision."""

    @property
    def shape(self) -> tuple[int, ...]:
        """(W, N, D) for features, (W, N, samples, 6) for windows."""

    def patches(self, which: Which) -> np.ndarray:
        """All windows of P patches, shape (W, P, ...)."""


@dataclass(frozen=True, eq=False)
class ArrayBlocks:
    """An array (W, N, ...) in memory as `PatchBlocks`."""

    array: np.ndarray

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return self.array.shape

    def patches(self, which: Which) -> np.ndarray:
        """A view of neighbouring patches, a copy of others."""
        runs = _runs(which, self.shape[1])
        return self.array[:, slice(*runs[0]) if len(runs) == 1 else which]


@dataclass(frozen=True, eq=False)
class SomeWindows:
    """Some windows of another source."""

    source: PatchBlocks
    rows: np.ndarray  # (V,), int: the windows wanted

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape with the wanted windows alone."""
        return (len(self.rows), *self.source.shape[1:])

    def patches(self, which: Which) -> np.ndarray:
        """The wanted windows of some patches; from files no others are read."""
        if isinstance(self.source, FeatureFiles) and (np.diff(self.rows) > 0).all():
            return self.source.patches(which, self.rows)
        block = self.source.patches(which)
        if np.array_equal(self.rows, np.arange(len(block))):
            return block
        return block[self.rows]


@dataclass(frozen=True, eq=False)
class SomePatches:
    """Patches of another source."""

    source: PatchBlocks
    numbers: np.ndarray  # (P,), int, rising

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape with these patches alone."""
        n_windows, _, *rest = self.source.shape
        return (n_windows, len(self.numbers), *rest)

    def patches(self, which: Which) -> np.ndarray:
        """All windows of some of them."""
        return self.source.patches(self.numbers[which])


def _runs(which: Which, n_patches: int) -> list[tuple[int, int]]:
    """Runs of neighbouring patches, end exclusive: a file is read run by run."""
    numbers = np.arange(n_patches)[which]
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1)
    return [(int(run[0]), int(run[-1]) + 1) for run in runs]


def as_blocks(inputs: np.ndarray | PatchBlocks) -> PatchBlocks:
    """An array in memory, or a source that serves blocks already, as a source."""
    return inputs if isinstance(inputs, PatchBlocks) else ArrayBlocks(np.asarray(inputs))


def spans(source: PatchBlocks, budget: int = BLOCK_BYTES) -> list[slice]:
    """Patches of blocks within a budget of bytes, or of one patch."""
    n_windows, n_patches, *rest = source.shape
    return chunks(n_patches, max(1, budget // max(1, n_windows * math.prod(rest) * ITEM_BYTES)))


def for_each_patch(
    source: PatchBlocks,
    work: Callable[[int, np.ndarray], None],
    workers: int,
    budget: int,
    progress: Callable[[float], None] | None,
    at_once: int = 1,
) -> None:
    """Call `work` in threads with the number of a patch and its windows (1, W, ...).

    With `at_once`, it is the first of that many patches, with the windows of all. No more than a budget of
    bytes is held. `progress` is given the fraction done.
    """
    with ThreadPoolExecutor(workers) as pool:
        for span in spans(source, budget):
            held = source.patches(span).swapaxes(0, 1)
            parts = chunks(len(held), at_once)
            calls = pool.map(work, (span.start + part.start for part in parts), map(held.__getitem__, parts))
            for part, _ in zip(parts, calls, strict=True):
                if progress is not None:
                    progress((span.start + part.stop) / source.shape[1])
            del held  # before the next is read


class FeatureFiles:
    """Features of clips, one file each, one after another.

    Each file holds an array ``features``, shape (windows of the clip, N, D), float32, uncompressed. Raises
    ValueError for one that does not, or that holds other patches than the first.
    """

    def __init__(self, paths: Sequence[Path]) -> None:
        self._parts = [StoredArray.find(path, "features") for path in paths]
        for part in self._parts:
            if part.shape[1:] != self._parts[0].shape[1:]:
                raise ValueError(
                    f"{part.path} holds features of shape {part.shape[1:]}, others {self._parts[0].shape[1:]}"
                )
        self._starts = np.cumsum([0, *(part.shape[0] for part in self._parts)])

    @property
    def shape(self) -> tuple[int, ...]:
        """(W, N, D)."""
        return (int(self._starts[-1]), *self._parts[0].shape[1:])

    def patches(self, which: Which, windows: np.ndarray | None = None) -> np.ndarray:
        """Features of P patches, (W, P, D): of all windows or of some, rising."""
        runs = _runs(which, self.shape[1])
        wanted = np.arange(self.shape[0]) if windows is None else windows
        n_patches = sum(last - first for first, last in runs)
        block = np.empty((len(wanted), n_patches, *self.shape[2:]), dtype=np.float32)
        ends = np.searchsorted(wanted, self._starts)
        for part, start, begin, end in zip(self._parts, self._starts, ends, ends[1:], strict=False):
            if begin < end:
                part.read_columns(runs, wanted[begin:end] - start, block[begin:end])
        return block


class WindowFiles:
    """Windows of clips, cut from the files of their recordings.

    The files are those of `ImuRecording.save`, all at one rate; `windows` are the numbers of windows that
    `cut_windows` makes of each whole recording. Raises ValueError for a file that is no recording.
    """

    def __init__(self, paths: Sequence[Path], windows: Sequence[int], spec: WindowSpec) -> None:
        self._paths, self._counts, self._spec = list(paths), list(windows), spec
        self._parts = [(StoredArray.find(path, "acc"), StoredArray.find(path, "gyr")) for path in paths]
        self._rates = [float(load_arrays(path, ("rate",), "is no recording")["rate"]) for path in paths]
        self._ends = np.cumsum(windows)
        self._chosen: dict[int, np.ndarray] = {}

    @property
    def shape(self) -> tuple[int, ...]:
        """(W, N, samples, 6)."""
        n_patches = self._parts[0][0].shape[1]
        return (int(self._ends[-1]), n_patches, self._spec.samples(self._rates[0]), 6)

    def patches(self, which: Which) -> np.ndarray:
        """Windows of P patches, shape (W, P, samples, 6)."""
        n_windows, n_patches, *rest = self.shape
        runs = _runs(which, n_patches)
        block = np.empty((n_windows, sum(last - first for first, last in runs), *rest), dtype=np.float32)
        for clip, (acc, gyr) in enumerate(self._parts):
            rate, end = self._rates[clip], self._ends[clip]
            recording = ImuRecording(acc.columns(runs), gyr.columns(runs), rate)
            starts = self._starts(clip, acc.shape[0], rate)
            block[end - self._counts[clip] : end] = cut_windows(recording, self._spec, starts).signals
        return block

    def _starts(self, clip: int, n_samples: int, rate: float) -> np.ndarray | None:
        """Starts of the windows if a sensor elsewhere lost samples; None if all windows are there."""
        spec = self._spec
        all_of_them = max(0, n_samples - spec.samples(rate)) // spec.stride(rate) + 1
        if self._counts[clip] == all_of_them:
            return None
        if clip not in self._chosen:
            self._chosen[clip] = window_starts(ImuRecording.load(self._paths[clip]), spec)
        return self._chosen[clip]


class CutRecordings(NamedTuple):
    """Windows of the recordings that give some."""

    used: list[int]  # the numbers of these recordings
    inputs: list[np.ndarray]  # of each: features (W, N, D), or windows (W, N, samples, 6)
    is_test: list[np.ndarray]  # of each: the mask (W,) of test windows
    skipped: dict[int, str]  # the numbers of the others, each with the reason


def cut_recordings(
    recordings: Sequence[ImuRecording],
    spec: WindowSpec,
    inputs: str = "features",
    view: Callable[[np.ndarray], np.ndarray] | None = None,
) -> CutRecordings:
    """Cut recordings into windows and describe these.

    `inputs` {"features", "windows"} is what the classifier takes (`utility.inputs_of`); `view` is what is
    made of windows (W, N, samples, 6) before anything else looks at them.
    """
    found = CutRecordings([], [], [], {})
    for number, recording in enumerate(recordings):
        try:
            windows = cut_windows(recording, spec)
        except TooShortError as error:
            found.skipped[number] = str(error)
            continue
        cut = windows.signals if view is None else view(windows.signals)
        found.inputs.append(window_features(cut, recording.rate) if inputs == "features" else cut)
        found.is_test.append(windows.is_test)
        found.used.append(number)
    return found
