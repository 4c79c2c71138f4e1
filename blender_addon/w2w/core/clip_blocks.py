# SPDX-License-Identifier: GPL-3.0-or-later
"""Features or windows of a whole library, read from its clips' files some places at a time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from .npz_slices import StoredArray
from .place_blocks import PlaceBlocks
from .recording import ImuRecording
from .windows import WindowSpec, cut_windows, window_starts


def clip_inputs(
    kind: Literal["features", "windows"],
    features: Sequence[Path],
    recordings: Sequence[Path],
    windows: Sequence[int],
    spec: WindowSpec,
) -> PlaceBlocks:
    """What a classifier takes of a library, features or windows, from the files that hold it.

    Parameters
    ----------
    kind : {"features", "windows"}
        What the classifier takes, as `utility.inputs_of` says.
    features, recordings, windows, spec
        As for `FeatureFiles` and `WindowFiles`.
    """
    if kind == "features":
        return FeatureFiles(features)
    return WindowFiles(recordings, windows, spec)


class FeatureFiles:
    """Features of clips, one file each, one after another.

    Parameters
    ----------
    paths : sequence of Path
        Files with an array ``features``, shape (windows of the clip, N, D), float32, uncompressed.

    Raises
    ------
    OSError
        If a file is not there.
    ValueError
        If one does not hold features, or of other places than the first.
    """

    fresh: ClassVar[bool] = True
    """What `places` gives is the receiver's own."""

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

    def places(self, first: int, last: int) -> np.ndarray:
        """Features of some places, shape (W, last - first, D)."""
        block = np.empty((len(self), last - first, *self.shape[2:]), dtype=np.float32)
        for part, start in zip(self._parts, self._starts, strict=False):
            block[start : start + part.shape[0]] = part.columns(first, last)
        return block

    def __len__(self) -> int:
        return self.shape[0]


class WindowFiles:
    """Windows of clips, cut anew from the files of their recordings.

    Parameters
    ----------
    paths : sequence of Path
        Files that `ImuRecording.save` wrote, all at one rate.
    windows : sequence of int
        Windows of each clip, as `cut_windows` of the whole recording makes them.
    spec : WindowSpec

    Raises
    ------
    OSError
        If a file is not there.
    ValueError
        If one is no recording.
    """

    fresh: ClassVar[bool] = True
    """What `places` gives is the receiver's own."""

    def __init__(self, paths: Sequence[Path], windows: Sequence[int], spec: WindowSpec) -> None:
        self._paths, self._spec = list(paths), spec
        self._parts = [
            (StoredArray.find(path, "acc"), StoredArray.find(path, "gyr"), _rate(path)) for path in paths
        ]
        self._ends = np.cumsum(windows)
        self._counts = list(windows)
        self._chosen: dict[int, np.ndarray] = {}

    @property
    def shape(self) -> tuple[int, ...]:
        """(W, N, samples, 6)."""
        acc, _, rate = self._parts[0]
        return (int(self._ends[-1]), acc.shape[1], self._spec.samples(rate), 6)

    def places(self, first: int, last: int) -> np.ndarray:
        """Windows of some places, shape (W, last - first, samples, 6)."""
        shape = self.shape
        block = np.empty((shape[0], last - first, *shape[2:]), dtype=np.float32)
        for clip, (count, end) in enumerate(zip(self._counts, self._ends, strict=True)):
            acc, gyr, rate = self._parts[clip]
            recording = ImuRecording(acc.columns(first, last), gyr.columns(first, last), rate)
            block[end - count : end] = cut_windows(
                recording, self._spec, self._starts(clip, acc.shape[0], rate)
            ).signals
        return block

    def _starts(self, clip: int, n_samples: int, rate: float) -> np.ndarray | None:
        """Where the windows start, where a sensor elsewhere lost samples; None for all of them."""
        spec = self._spec
        all_of_them = max(0, n_samples - spec.samples(rate)) // spec.stride(rate) + 1
        if self._counts[clip] == all_of_them:
            return None
        if clip not in self._chosen:
            self._chosen[clip] = window_starts(ImuRecording.load(self._paths[clip]), spec)
        return self._chosen[clip]


def _rate(path: Path) -> float:
    with np.load(path, allow_pickle=False) as data:
        return float(data["rate"])
