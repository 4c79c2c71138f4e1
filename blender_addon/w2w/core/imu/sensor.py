# SPDX-License-Identifier: GPL-3.0-or-later
"""A real inertial sensor's effect on the ideal signal, part by part, each with its own switch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np

from ..filtering import butterworth, count_resampled, resample, sampled
from ..threads import chunks, for_each
from . import errors
from .errors import ALL_CLIPS, SensorStreams
from .recording import ImuRecording

CHUNK_VALUES = 800_000
"""About the values of a chunk of sensors: many against the cost of a call, few in memory."""

FULL_SCALE = 0.01
"""Share of a clip's samples at the sensor's full scale beyond which the clip is doubted."""


@dataclass(frozen=True)
class Triad:
    """Three axes of one kind, in one unit u: m/s2 for an accelerometer, rad/s for a gyroscope.

    Random constants are drawn for every sensor and clip, Gaussian, with the given value as their
    standard deviation. 0 or None switches a part off.

    Parameters
    ----------
    full_scale : float or None
        Readings are clipped to plus or minus this, u.
    resolution : float
        Step of the digital output, u per count.
    noise_density : float
        White noise, one-sided as datasheets print it, u/sqrt(Hz). A sample's deviation is this times the
        square root of the bandwidth; the random walk coefficient of the Allan plot is this over sqrt(2).
    bias_instability : float
        Coefficient B of the Allan plot, whose floor is .664 B, u; a first-order Gauss-Markov process.
    correlation_s : float
        Correlation time of the bias instability, s.
    random_walk : float
        Rate random walk coefficient K of the Allan plot: the bias strays as K sqrt(time), u/sqrt(s).
    turn_on_bias : float
        Constant bias of each axis, u.
    scale_error : float
        Relative error of each axis's sensitivity, 0.01 is one per cent.
    misalignment_deg : float
        Turn of the triad against its case, degrees about each axis.
    nonorthogonality_deg : float
        Lean of the axes towards each other, degrees.
    lowpass_hz : float or None
        -3 dB bandwidth, Hz. At or above half the sample rate no filter is run, but the noise folds in.
    lowpass_of_rate : float or None
        The same as a part of the output rate, at most 0.5, for parts whose filter follows their data rate.
    lowpass_order : int
        Order of the Butterworth filter.
    """

    full_scale: float | None = None
    resolution: float = 0.0
    noise_density: float = 0.0
    bias_instability: float = 0.0
    correlation_s: float = 100.0
    random_walk: float = 0.0
    turn_on_bias: float = 0.0
    scale_error: float = 0.0
    misalignment_deg: float = 0.0
    nonorthogonality_deg: float = 0.0
    lowpass_hz: float | None = None
    lowpass_of_rate: float | None = None
    lowpass_order: int = 2

    def __post_init__(self) -> None:
        if self.lowpass_of_rate is not None and (self.lowpass_of_rate > 0.5 or self.lowpass_hz is not None):
            raise ValueError("lowpass_of_rate must be at most 0.5, and stand without lowpass_hz")
        if not self.correlation_s >= errors.DRIFT_STEP_S:
            raise ValueError(
                f"correlation_s must be at least {errors.DRIFT_STEP_S}, not {self.correlation_s}"
            )
        if not 1 <= self.lowpass_order <= 8:
            raise ValueError(f"lowpass_order must be 1 to 8, not {self.lowpass_order}")
        _check_figures(self)

    def bandwidth(self, rate: float) -> float | None:
        """-3 dB bandwidth at an output rate, Hz."""
        return self.lowpass_hz if self.lowpass_of_rate is None else self.lowpass_of_rate * rate


@dataclass(frozen=True)
class SensorModel:
    """An inertial measurement unit and the way it is worn.

    Parameters
    ----------
    name : str
    accelerometer, gyroscope : Triad
        In m/s2 and rad/s.
    g_sensitivity : float
        Response of the gyroscope to specific force, each of nine coefficients, (rad/s)/(m/s2).
    zero_phase : bool
        Run the low-pass filters forwards and backwards; causal, as in hardware, otherwise.
    rate_hz : float or None
        Output rate; None keeps the recording's. A triad with a low-pass is sampled through that alone, so
        that the rest folds back (aliasing), as in a part; one without gets a filter that leaves nothing.
    jitter_s : float
        Standard deviation of the sampling instants, s, at most half a period.
    drop_fraction : float
        Part of the samples that are lost, 0 to 1.
    drop_duration_s : float
        Mean length of a loss, s; 0 loses single samples.
    dropped : {"hold", "nan"}
        Repeat the last sample that arrived, as most receivers do, or write NaN.
    mounting_turn_deg : float
        Turn of the sensor on the skin, degrees about each axis.
    mounting_shift_m : float
        Shift of the sensor on the skin along each axis, m.
    fixed_misalignment_deg : float
        Turn of the sensor against its place, degrees about each axis, the same in every clip, as if it
        were never taken off: it depends on the seed and the sensor's number alone.
    worn_turn_deg : tuple of 3 floats
        How a sensor really sat: rotation vector from its axes to those of its place, degrees, the same for
        every sensor and clip.
    soft_tissue_hz : float or None
        Natural frequency of the soft tissue under the sensor, Hz; at or above half the sample rate the
        tissue counts as stiff.
    soft_tissue_damping : float
        Its damping ratio.
    soft_tissue_gain : float
        Part of the sensor's motion that goes through the tissue, 0 to 1.

    Examples
    --------
    >>> w2w.SensorModel("loose band", mounting_turn_deg=10.0, mounting_shift_m=0.01).mounting_turn_deg
    10.0
    """

    name: str = "ideal"
    accelerometer: Triad = field(default_factory=Triad)
    gyroscope: Triad = field(default_factory=Triad)
    g_sensitivity: float = 0.0
    zero_phase: bool = False
    rate_hz: float | None = None
    jitter_s: float = 0.0
    drop_fraction: float = 0.0
    drop_duration_s: float = 0.0
    dropped: str = "hold"
    mounting_turn_deg: float = 0.0
    mounting_shift_m: float = 0.0
    fixed_misalignment_deg: float = 0.0
    worn_turn_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    soft_tissue_hz: float | None = None
    soft_tissue_damping: float = 0.3
    soft_tissue_gain: float = 1.0

    def __post_init__(self) -> None:
        _check_figures(self)
        turn = tuple(float(angle) for angle in self.worn_turn_deg)
        if len(turn) != 3 or not np.isfinite(turn).all():
            raise ValueError(f"worn_turn_deg must be three numbers, not {self.worn_turn_deg}")
        object.__setattr__(self, "worn_turn_deg", turn)
        if self.drop_fraction >= 1 or self.soft_tissue_gain > 1:
            raise ValueError("drop_fraction must be below 1 and soft_tissue_gain at most 1")
        if self.dropped not in ("hold", "nan"):
            raise ValueError(f'dropped must be "hold" or "nan", not {self.dropped!r}')

    @classmethod
    def ideal(cls) -> SensorModel:
        """A sensor without errors."""
        return cls()

    @property
    def is_ideal(self) -> bool:
        """Whether it has no error of any kind."""
        return replace(self, name="ideal", rate_hz=None) == SensorModel()

    def apply(self, recording: ImuRecording, seed: int, sensors: Sequence[int] | None = None) -> ImuRecording:
        """This sensor's readings of a motion whose true signals the recording holds.

        Parameters
        ----------
        recording : ImuRecording
            Ideal signals.
        seed : int
            At least 0. Random numbers depend on the seed, the recording's clip and the sensor's number
            alone, not on how the sensors are shared out among calls or workers.
        sensors : sequence of int, optional
            Numbers of the recording's sensors, if they are a part of a larger set.

        Returns
        -------
        ImuRecording
        """
        numbers = range(recording.n_sensors) if sensors is None else sensors
        if seed < 0 or min(numbers, default=0) < 0:
            raise ValueError(f"seed and sensors' numbers must not be negative: {seed}, {sensors}")
        rate = self.rate_hz or recording.rate
        n_samples = count_resampled(recording.n_samples, recording.rate, rate)
        acc = np.empty((n_samples, recording.n_sensors, 3), dtype=np.float32)
        gyr = np.empty_like(acc)
        size = max(1, CHUNK_VALUES // (6 * recording.n_samples))

        def fill(chunk: slice) -> None:
            streams = SensorStreams(seed, recording.clip, numbers[chunk])
            # sensor by sensor, (n, 3, T)
            true_acc = np.ascontiguousarray(recording.acc[:, chunk].transpose(1, 2, 0))
            true_gyr = np.ascontiguousarray(recording.gyr[:, chunk].transpose(1, 2, 0))
            read = self._read(true_acc, true_gyr, recording.rate, streams)
            for out, values in zip((acc, gyr), read, strict=True):
                out[:, chunk] = values.transpose(2, 0, 1)

        for_each(fill, chunks(recording.n_sensors, size))
        return replace(recording, acc=acc, gyr=gyr, rate=rate)

    def full_scale_content(self, recording: ImuRecording) -> dict[str, float]:
        """The share of a recording's samples at full scale, for a clip's record; {} if it is usual."""
        share = self.at_full_scale(recording)
        return {"at_full_scale": round(share, 3)} if share > FULL_SCALE else {}

    def at_full_scale(self, recording: ImuRecording) -> float:
        """Share of a recording's samples, of all its sensors, in which an axis reads the end of its range."""
        full = np.zeros(recording.acc.shape[:2], dtype=bool)
        for values, triad in ((recording.acc, self.accelerometer), (recording.gyr, self.gyroscope)):
            if triad.full_scale is not None:
                at_end = np.abs(values) >= triad.full_scale - triad.resolution
                if at_end.any():  # in few clips
                    full |= at_end[..., 0] | at_end[..., 1] | at_end[..., 2]  # any(axis=2) takes 7 times
        return float(full.mean())

    def sits(self, streams: SensorStreams) -> list[tuple[np.ndarray, np.ndarray]]:
        """How sensors sit on their places: shifts (n, 3), m, and the turns (n, 3), rad, after them, in order.

        First as one was worn, then each by its own misalignment in all clips, then as put on for this one.
        """
        n = len(streams.sensors)
        here, fixed = np.zeros((n, 2, 3)), np.zeros((n, 3))
        if self.mounting_turn_deg or self.mounting_shift_m:
            here = streams.constants("mounting", 2, 3)
        if self.fixed_misalignment_deg:
            fixed = streams.of_clip(ALL_CLIPS).constants("mounting", 2, 3)[:, 0]
        worn = np.tile(np.radians(self.worn_turn_deg), (n, 1))
        return [
            (np.zeros((n, 3)), worn),
            (np.zeros((n, 3)), np.radians(self.fixed_misalignment_deg) * fixed),
            (self.mounting_shift_m * here[:, 1], np.radians(self.mounting_turn_deg) * here[:, 0]),
        ]

    def _read(
        self, acc: np.ndarray, gyr: np.ndarray, rate: float, streams: SensorStreams
    ) -> list[np.ndarray]:
        """The whole chain on arrays of shape (n, 3, T), from the skin to the last bit."""
        for shifts, turns in self.sits(streams):
            if shifts.any() or turns.any():
                acc, gyr = errors.mount(acc, gyr, rate, turns, shifts)
        if self.soft_tissue_hz is not None and self.soft_tissue_hz < rate / 2:
            tissue = (self.soft_tissue_hz, self.soft_tissue_damping, self.soft_tissue_gain)
            acc, gyr = (errors.soft_tissue_artefact(values, rate, *tissue) for values in (acc, gyr))
        if self.g_sensitivity:
            response = self.g_sensitivity * streams.constants("g-sensitivity", 3, 3)
            gyr = gyr + response @ acc
        rate_out = self.rate_hz or rate
        read = []
        for kind, triad, values in (("acc", self.accelerometer, acc), ("gyr", self.gyroscope, gyr)):
            bandwidth = triad.bandwidth(rate_out)
            values = _sense(values, triad, kind, rate, bandwidth, streams)
            if bandwidth is not None and bandwidth < rate / 2:
                values = butterworth(values, rate, bandwidth, triad.lowpass_order, self.zero_phase)
            read.append((resample if bandwidth is None else sampled)(values, rate, rate_out))
        if self.jitter_s:
            offsets = streams.normal("jitter", read[0].shape[-1]) * np.float32(self.jitter_s * rate_out)
            read = [errors.jitter(values, offsets) for values in read]
        for values, triad in zip(read, (self.accelerometer, self.gyroscope), strict=True):
            errors.quantise(values, triad.full_scale, triad.resolution)
        self.lose(read, rate_out, streams)
        return read

    def lose(self, signals: Sequence[np.ndarray], rate: float, streams: SensorStreams) -> None:
        """Lose the same samples of all signals, (sensors, axes, samples) each, in place."""
        if not self.drop_fraction:
            return
        mean_length = max(1.0, self.drop_duration_s * rate)
        for row, generator in enumerate(streams.generators("drops")):
            kept = errors.kept_samples(generator, signals[0].shape[-1], self.drop_fraction, mean_length)
            for values in signals:
                errors.lose(values[row], kept, self.dropped)


def _sense(
    values: np.ndarray, triad: Triad, kind: str, rate: float, bandwidth: float | None, streams: SensorStreams
) -> np.ndarray:
    """Axes, biases and noise of one triad; shape (n, 3, T)."""
    if triad.scale_error or triad.misalignment_deg or triad.nonorthogonality_deg:
        scale, turns, shears = streams.constants(f"{kind} axes", 3, 3).transpose(1, 0, 2)
        matrix = errors.axes_matrix(
            triad.scale_error * scale,
            np.radians(triad.misalignment_deg) * turns,
            np.radians(triad.nonorthogonality_deg) * shears,
        )
        values = matrix.astype(np.float32) @ values
    if triad.turn_on_bias:
        values = values + np.float32(triad.turn_on_bias) * streams.constants(f"{kind} bias", 3, 1)
    if triad.bias_instability or triad.random_walk:
        times = np.arange(values.shape[-1]) / rate
        numbers = streams.normal(f"{kind} drift", 2, 3, int(times[-1] / errors.DRIFT_STEP_S) + 2)
        deviation = triad.bias_instability * errors.FLICKER_FLOOR / errors.GAUSS_MARKOV_PEAK
        knots = errors.bias_drift(numbers, deviation, triad.correlation_s, triad.random_walk)
        drift = errors.join(knots, times)
        values = np.add(values, drift, out=drift)
    if triad.noise_density:
        deviation = errors.noise_deviation(triad.noise_density, rate, bandwidth, triad.lowpass_order)
        noise = streams.normal(f"{kind} noise", *values.shape[1:])
        noise *= np.float32(deviation)
        values = np.add(values, noise, out=noise)
    return values


def _check_figures(record: Triad | SensorModel) -> None:
    """Refuse negative figures, and 0 where None switches a part off."""
    for item in fields(record):
        value = getattr(record, item.name)
        if isinstance(item.default, float) and not (np.isfinite(value) and value >= 0):
            raise ValueError(f"{item.name} must be 0 or more, not {value}")
        if item.default is None and value is not None and not (np.isfinite(value) and value > 0):
            raise ValueError(f"{item.name} must be positive, or None to switch it off, not {value}")
