# SPDX-License-Identifier: GPL-3.0-or-later
"""Cut a recording into windows: overlapping ones to train on, separate ones to test on."""

from dataclasses import dataclass
from numbers import Real
from typing import Literal, NamedTuple, Self

import numpy as np

from ..imu.recording import ImuRecording
from ..parameters import parameter

ShortClips = Literal["reflect", "cycle", "refuse"]

STRIDE = 0.5
"""Share of a window's length after which the next training window starts by default."""


MOST_TURNS = 50
"""Length of a window in clips above which the clip is refused: it would be little but repetition."""


class TooShortError(ValueError):
    """A recording, or every stretch of it without long gaps, is too short to give one window."""


class Windows(NamedTuple):
    """Windows of one recording.

    `signals` (W, N, samples, 6), float32, read-only, are specific force (m/s2), then angular velocity
    (rad/s), in the sensor frame: a view into one copy of the recording, so that overlapping windows cost no
    memory. `is_test` (W,), bool, marks windows that do not overlap one another; the others are for training.
    `starts` (W,) are their first samples.
    """

    signals: np.ndarray
    is_test: np.ndarray
    starts: np.ndarray


@dataclass(frozen=True)
class WindowSpec:
    """How recordings are cut.

    Parameters
    ----------
    length_s : float
        Seconds a window lasts.
    stride_s : float
        Seconds from one training window's start to the next. Test windows are the
        subset of them that do not overlap.
    short : {"reflect", "cycle", "refuse"}
        What to do with a recording shorter than one window. ``reflect`` plays it
        forwards and backwards in turn: specific force is unchanged by the reversal
        of time and angular velocity changes sign, so what is added is again a motion
        that a body could do, without the jump that joining the end to the beginning
        makes. ``cycle`` repeats it, right for clips known to loop without a seam.
        ``refuse`` raises TooShortError.
    shortest_s : float
        Recordings shorter than this, or than a fiftieth of a window, are refused whatever `short` says.
    longest_gap_s : float
        Lost samples (NaN) are bridged by straight lines up to this; windows with a
        longer gap in any sensor are left out.

    Raises
    ------
    ValueError
        If a length is not positive, the stride exceeds the length, or `short` is unknown.

    Examples
    --------
    >>> w2w.WindowSpec(length_s=3.0, stride_s=1.5).stride_s
    1.5
    """

    length_s: float = parameter(
        2.0,
        "Window length: seconds of signal that an activity is recognised from.",
        "window",
        title="Window", unit="s", least=0.1, most=600, usual=(0.2, 30),
    )  # fmt: skip
    stride_s: float = 1.0
    short: ShortClips = "reflect"
    shortest_s: float = 0.5
    longest_gap_s: float = 0.1

    def __post_init__(self) -> None:
        if not (isinstance(self.length_s, Real) and np.isfinite(self.length_s) and self.length_s > 0):
            raise ValueError(f"length_s must be a positive number of seconds, not {self.length_s!r}")
        if not isinstance(self.stride_s, Real) or not 0 < self.stride_s <= self.length_s:
            raise ValueError(f"stride_s must be in (0, length_s = {self.length_s}], not {self.stride_s}")
        if self.short not in ("reflect", "cycle", "refuse"):
            raise ValueError(f"short must be 'reflect', 'cycle' or 'refuse', not {self.short!r}")
        if not self.shortest_s > 0:
            raise ValueError(f"shortest_s must be a positive number of seconds, not {self.shortest_s}")
        if not self.longest_gap_s >= 0:
            raise ValueError(f"longest_gap_s must be 0 or more seconds, not {self.longest_gap_s}")

    @classmethod
    def of_length(cls, length_s: float, stride_s: float | None = None) -> Self:
        """Windows with half their length as stride if none is given."""
        if stride_s is None and isinstance(length_s, Real):
            stride_s = STRIDE * length_s
        return cls(length_s, cls.stride_s if stride_s is None else stride_s)

    @property
    def least_s(self) -> float:
        """Seconds that a recording must last."""
        return self.length_s if self.short == "refuse" else max(self.shortest_s, self.length_s / MOST_TURNS)

    def samples(self, rate: float) -> int:
        """Samples in a window at `rate` Hz."""
        return max(2, round(self.length_s * rate))

    def stride(self, rate: float) -> int:
        """Samples from one window's start to the next at `rate` Hz."""
        return max(1, round(self.stride_s * rate))


def cut_windows(recording: ImuRecording, spec: WindowSpec, starts: np.ndarray | None = None) -> Windows:
    """Cut a recording into windows, at least one; less than a stride at the end is not used.

    `starts` (W,) are the first samples, from `window_starts` of a recording that these sensors are part of;
    by default every window without a long gap is cut.

    Raises
    ------
    TooShortError
        If there is not one window; the message says why.
    """
    samples = spec.samples(recording.rate)
    signals = _prepared(recording, spec)
    if starts is None:
        starts = _whole_windows(signals, recording, spec)
    views = np.lib.stride_tricks.sliding_window_view(signals, samples, axis=0)
    stride = spec.stride(recording.rate)
    regular = len(starts) == len(views[::stride])  # a view then, where an index would copy
    chosen = views[::stride] if regular else views[starts]
    return Windows(np.moveaxis(chosen, 3, 2), _separate(starts, samples), starts)


def window_starts(recording: ImuRecording, spec: WindowSpec) -> np.ndarray:
    """First sample of each window that `cut_windows` makes, shape (W,), int; with the same errors."""
    return _whole_windows(_prepared(recording, spec), recording, spec)


def cut_at_windows(values: np.ndarray, recording: ImuRecording, spec: WindowSpec) -> np.ndarray:
    """Cut readings (T, N, k) besides acc and gyr into the windows that `cut_windows` makes of these.

    The windows (W, N, k, samples) are a view if the recording is not shorter than a window and loses no
    samples.
    """
    samples = spec.samples(recording.rate)
    starts = window_starts(recording, spec)
    if np.isnan(values).any():
        values = values.copy()
        _bridge_gaps(values, round(spec.longest_gap_s * recording.rate))
    if len(values) < samples:
        values = values[_played(len(values), samples, spec.short)[0]]
    return np.lib.stride_tricks.sliding_window_view(values, samples, axis=0)[starts]


def _prepared(recording: ImuRecording, spec: WindowSpec) -> np.ndarray:
    """Signals (T, N, 6) with short gaps bridged, and at least a window long."""
    samples = spec.samples(recording.rate)
    # channel by channel in memory, so that each operation on a window is one for all sensors
    signals = np.empty((recording.n_samples, 6, recording.n_sensors), dtype=np.float32).transpose(0, 2, 1)
    signals[..., :3], signals[..., 3:] = recording.acc, recording.gyr
    _bridge_gaps(signals, round(spec.longest_gap_s * recording.rate))
    if len(signals) < samples:
        duration = recording.n_samples / recording.rate
        if duration < (limit := spec.least_s):
            raise TooShortError(
                f"clip {recording.clip!r} lasts {duration:.2f} s, shorter than the {limit:g} s a window needs"
            )
        frames, backwards = _played(len(signals), samples, spec.short)
        signals = signals[frames]
        signals[backwards, :, 3:] *= -1.0
    return signals


def _whole_windows(signals: np.ndarray, recording: ImuRecording, spec: WindowSpec) -> np.ndarray:
    """Starts of the windows in which no sensor has a gap."""
    samples, stride = spec.samples(recording.rate), spec.stride(recording.rate)
    starts = np.arange(0, len(signals) - samples + 1, stride)
    broken = np.concatenate([[0], np.isnan(signals).any(axis=(1, 2)).cumsum()])
    whole = starts[broken[starts + samples] == broken[starts]]
    if not len(whole):
        raise TooShortError(
            f"clip {recording.clip!r} has no {spec.length_s:g} s without a gap of lost samples longer "
            f"than {spec.longest_gap_s:g} s"
        )
    return whole


def _separate(starts: np.ndarray, samples: int) -> np.ndarray:
    """Mark the first window and each next one that does not overlap the last marked."""
    marked = np.zeros(len(starts), dtype=bool)
    free = 0
    for number, start in enumerate(starts):
        if start >= free:
            marked[number] = True
            free = start + samples
    return marked


def _bridge_gaps(signals: np.ndarray, longest: int) -> None:
    """Fill runs of at most `longest` lost samples of a sensor by straight lines, in place."""
    lost = np.isnan(signals).any(axis=2)
    for sensor in np.flatnonzero(lost.any(axis=0) & ~lost.all(axis=0)):
        given, missing = np.flatnonzero(~lost[:, sensor]), np.flatnonzero(lost[:, sensor])
        after = np.searchsorted(given, missing)
        inside = (after > 0) & (after < len(given))
        missing, after = missing[inside], after[inside]
        missing = missing[given[after] - given[after - 1] - 1 <= longest]
        for channel in range(signals.shape[2]):
            values = signals[:, sensor, channel]
            values[missing] = np.interp(missing, given, values[given])


def _played(n_frames: int, samples: int, how: ShortClips) -> tuple[np.ndarray, np.ndarray]:
    """Frame played at each sample, and whether backwards: in turn with forwards, unless it is a cycle."""
    lap, position = np.divmod(np.arange(samples), n_frames)
    if how == "cycle":
        return position, np.zeros(samples, dtype=bool)
    backwards = lap % 2 == 1
    return np.where(backwards, n_frames - 1 - position, position), backwards
