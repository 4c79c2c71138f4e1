# SPDX-License-Identifier: GPL-3.0-or-later
"""Every part of the sensor model does what its parameter says, and noise does not depend on company."""

from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.signal import welch

from w2w.core.imu.errors import FLICKER_FLOOR
from w2w.core.imu.presets import DEFAULT_SENSOR, PRESETS, preset
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel, Triad

G = 9.80665


def at_rest(n_samples: int, n_sensors: int = 1, rate: float = 50, clip: str = "rest") -> ImuRecording:
    acc = np.zeros((n_samples, n_sensors, 3), dtype=np.float32)
    acc[..., 2] = G
    return ImuRecording(acc=acc, gyr=np.zeros_like(acc), rate=rate, clip=clip)


def moving(n_samples: int = 600, n_sensors: int = 4, rate: float = 100, clip: str = "walk") -> ImuRecording:
    rng = np.random.default_rng(0)
    t = np.arange(n_samples)[:, None, None] / rate
    hz, phase = rng.uniform(0.5, 4, (2, 1, n_sensors, 3)), rng.uniform(0, 6, (2, 1, n_sensors, 3))
    acc, gyr = (
        (size * np.sin(2 * np.pi * f * t + p)).astype(np.float32)
        for size, f, p in zip((8, 4), hz, phase, strict=True)
    )
    return ImuRecording(acc=acc + np.float32([0, 0, G]), gyr=gyr, rate=rate, clip=clip)


FULL = SensorModel(
    name="everything",
    accelerometer=Triad(
        full_scale=30.0,
        resolution=0.01,
        noise_density=0.02,
        bias_instability=0.05,
        correlation_s=20.0,
        random_walk=0.01,
        turn_on_bias=0.3,
        scale_error=0.02,
        misalignment_deg=1.0,
        nonorthogonality_deg=1.0,
        lowpass_hz=30.0,
    ),
    gyroscope=Triad(
        full_scale=6.0,
        resolution=0.001,
        noise_density=0.002,
        bias_instability=0.01,
        random_walk=0.001,
        turn_on_bias=0.05,
        scale_error=0.02,
        misalignment_deg=1.0,
        nonorthogonality_deg=1.0,
        lowpass_of_rate=0.3,
    ),
    g_sensitivity=0.001,
    jitter_s=0.001,
    drop_fraction=0.02,
    drop_duration_s=0.05,
    mounting_turn_deg=5.0,
    mounting_shift_m=0.01,
    soft_tissue_hz=12.0,
)


def allan_deviation(rate: np.ndarray, dt: float, lags: np.ndarray) -> np.ndarray:
    """Overlapping Allan deviation along axis 0 (IEEE Std 952-1997, C), averaged over the other axes."""
    angle = np.cumsum(np.concatenate([np.zeros_like(rate[:1]), rate]), axis=0, dtype=np.float64) * dt
    deviations = []
    for lag in lags:
        second = angle[2 * lag :] - 2 * angle[lag:-lag] + angle[: -2 * lag]
        deviations.append(np.sqrt((second**2).mean() / (2 * (lag * dt) ** 2)))
    return np.array(deviations)


def gauss_markov_variance(tau: np.ndarray, correlation: float) -> np.ndarray:
    """Allan variance of a first-order Gauss-Markov process of unit variance."""
    x = tau / correlation
    return 2 / x * (1 - (3 - 4 * np.exp(-x) + np.exp(-2 * x)) / (2 * x))


def test_an_ideal_sensor_reads_the_truth():
    truth = moving()
    read = SensorModel.ideal().apply(truth, seed=1)
    np.testing.assert_array_equal(read.acc, truth.acc)
    np.testing.assert_array_equal(read.gyr, truth.gyr)
    assert (read.rate, read.clip) == (truth.rate, truth.clip)


@pytest.mark.slow
@pytest.mark.later
def test_allan_deviation_reads_back_what_went_in():
    """Ten hours at rest: white noise, bias instability and rate random walk, each within 10 %."""
    rate = 4.0
    triad = Triad(noise_density=2e-3, bias_instability=1e-3, correlation_s=60.0, random_walk=1.2e-5)
    model = SensorModel(gyroscope=triad)
    seconds = 10 * 3600
    # the random walk read from ten hours of four sensors scatters by 9 % from seed to seed
    found = model.apply(at_rest(int(seconds * rate), n_sensors=12, rate=rate), seed=7).gyr
    lags = np.unique(np.geomspace(1, seconds * rate / 12, 30).astype(int))
    tau = lags / rate
    variance = allan_deviation(found, 1 / rate, lags) ** 2
    shapes = np.stack([1 / tau, gauss_markov_variance(tau, 60.0), tau / 3], axis=1)
    weights = np.sqrt(seconds / tau) / variance
    parts = np.linalg.lstsq(shapes * weights[:, None], variance * weights, rcond=None)[0]
    angle_walk, deviation, rate_walk = np.sqrt(parts)
    floor = deviation * np.sqrt(gauss_markov_variance(60.0 * np.linspace(1, 3, 200), 60.0).max())
    assert angle_walk * np.sqrt(2) == pytest.approx(2e-3, rel=0.1)
    assert floor / FLICKER_FLOOR == pytest.approx(1e-3, rel=0.1)
    assert rate_walk == pytest.approx(1.2e-5, rel=0.1)


@pytest.mark.later
def test_each_slope_of_the_allan_plot_on_its_own():
    """The textbook readings: N at 1 s of white noise, K of random walk, the top of the bias."""
    rate, seconds = 4.0, 10 * 3600

    def deviation(tau: float | np.ndarray, **part: float) -> np.ndarray:
        model = SensorModel(accelerometer=Triad(**part))
        found = model.apply(at_rest(int(seconds * rate), 4, rate), seed=3).acc - np.float32([0, 0, G])
        return allan_deviation(found, 1 / rate, np.rint(np.atleast_1d(tau) * rate).astype(int))

    assert deviation(1.0, noise_density=0.05)[0] == pytest.approx(0.05 / np.sqrt(2), rel=0.03)
    assert deviation(30.0, random_walk=1e-3)[0] == pytest.approx(1e-3 * np.sqrt(10), rel=0.1)
    highest = deviation(np.array([60, 90, 110, 130, 170]), bias_instability=0.02, correlation_s=60.0).max()
    assert highest == pytest.approx(0.664 * 0.02, rel=0.1)


@pytest.mark.parametrize("rate", [25.0, 100.0, 400.0])
def test_noise_has_the_density_asked_for_at_any_rate(rate):
    model = SensorModel(accelerometer=Triad(noise_density=0.01))
    noise = model.apply(at_rest(40_000, rate=rate), seed=0).acc[:, 0, 0]
    assert noise.mean() == pytest.approx(0, abs=0.002)
    assert noise.std() == pytest.approx(0.01 * np.sqrt(rate / 2), rel=0.02)
    _, power = welch(noise, fs=rate, nperseg=256)
    assert np.sqrt(power[5:-5].mean()) == pytest.approx(0.01, rel=0.03)


def test_noise_beyond_half_the_rate_folds_in():
    """A part with 100 Hz of bandwidth read at 50 Hz is noisier than one read at 200 Hz per sqrt(Hz)."""
    model = SensorModel(accelerometer=Triad(noise_density=0.01, lowpass_hz=100.0))
    noise = model.apply(at_rest(40_000, rate=50), seed=0).acc[:, 0, 0]
    assert noise.std() == pytest.approx(0.01 * np.sqrt(100 * np.pi / (2 * np.sqrt(2))), rel=0.03)


@pytest.mark.parametrize("rate", [20.0, pytest.param(80.0, marks=pytest.mark.slow)])
def test_bias_wanders_alike_at_any_rate(rate):
    """The same seed gives the same drift, sampled more or less often; its spread grows as sqrt(time)."""
    model = SensorModel(gyroscope=Triad(random_walk=0.01, bias_instability=0.02, correlation_s=30.0))
    drift = model.apply(at_rest(int(100 * rate) + 1, 2, rate), seed=5).gyr
    reference = model.apply(at_rest(1001, 2, 10), seed=5).gyr
    np.testing.assert_allclose(drift[:: int(rate / 10)], reference, atol=1e-6)
    walk = SensorModel(gyroscope=Triad(random_walk=0.01))
    ends = walk.apply(at_rest(int(100 * rate) + 1, 400, rate), seed=5).gyr
    assert np.abs(ends[0]).max() == 0
    assert ends[-1].std() == pytest.approx(0.01 * np.sqrt(100), rel=0.05)
    assert ends[int(25 * rate)].std() == pytest.approx(0.01 * np.sqrt(25), rel=0.05)


def test_constant_errors_have_the_spread_asked_for():
    truth = ImuRecording(
        acc=np.tile(np.float32([0, 0, G]), (3, 3000, 1)), gyr=np.ones((3, 3000, 3), np.float32), rate=50
    )
    bias = SensorModel(accelerometer=Triad(turn_on_bias=0.5)).apply(truth, 0).acc - truth.acc
    assert np.ptp(bias, axis=0).max() == 0
    assert bias[0].std() == pytest.approx(0.5, rel=0.03)
    scale = SensorModel(gyroscope=Triad(scale_error=0.03)).apply(truth, 0).gyr
    assert scale[0].std() == pytest.approx(0.03, rel=0.03)
    lean = SensorModel(accelerometer=Triad(nonorthogonality_deg=1.0)).apply(truth, 0).acc[0] / G
    np.testing.assert_array_equal(lean[:, :2], 0)
    felt = SensorModel(g_sensitivity=0.002).apply(truth, 0).gyr[0] - 1
    assert felt.std() == pytest.approx(0.002 * G, rel=0.03)


def test_a_misaligned_triad_is_turned_and_nothing_else():
    truth = moving(n_sensors=50)
    read = SensorModel(accelerometer=Triad(misalignment_deg=2.0)).apply(truth, 0)
    lengths = [np.linalg.norm(r.acc, axis=-1) for r in (read, truth)]
    np.testing.assert_allclose(*lengths, rtol=1e-5)
    cosine = (read.acc * truth.acc).sum(-1) / lengths[0] / lengths[1]
    assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).max() < 12
    np.testing.assert_array_equal(read.gyr, truth.gyr)


def test_mounting_turns_both_triads_alike_and_shifts_by_the_lever_arm():
    rate, omega = 200.0, 3.0
    t = np.arange(600) / rate
    spin = np.zeros((600, 30, 3), np.float32)
    spin[..., 2] = (omega * np.sin(2 * t))[:, None]
    truth = ImuRecording(acc=np.zeros_like(spin), gyr=spin, rate=rate)
    shifted = SensorModel(mounting_shift_m=0.05).apply(truth, 0)
    speed = omega * np.sin(2 * t)[1:-1, None]
    push = 2 * omega * np.cos(2 * t)[1:-1, None]
    inward = shifted.acc[1:-1]
    lever = -inward[300, :, :2] * speed[300] ** 2 + push[300] * np.stack(
        [inward[300, :, 1], -inward[300, :, 0]], 1
    )
    lever /= speed[300] ** 4 + push[300] ** 2
    np.testing.assert_allclose(inward[..., 0], -(speed**2) * lever[:, 0] - push * lever[:, 1], atol=2e-4)
    np.testing.assert_allclose(inward[..., 1], -(speed**2) * lever[:, 1] + push * lever[:, 0], atol=2e-4)
    assert lever.std() == pytest.approx(0.05, rel=0.3)
    np.testing.assert_array_equal(shifted.gyr, truth.gyr)

    worn = moving(n_sensors=20)
    turned = SensorModel(mounting_turn_deg=10.0).apply(worn, 0)
    for name in ("acc", "gyr"):
        before, after = (np.linalg.norm(getattr(r, name), axis=-1) for r in (worn, turned))
        np.testing.assert_allclose(after, before, rtol=2e-5)
    together = [(r.acc * r.gyr).sum(-1) for r in (worn, turned)]
    np.testing.assert_allclose(*together, atol=1e-3)


@pytest.mark.parametrize("zero_phase", [False, True])
@pytest.mark.parametrize("order", [1, 2, 4])
def test_the_filter_has_its_bandwidth_and_its_delay(zero_phase, order):
    rate, cutoff = 200.0, 20.0
    t = np.arange(4000) / rate
    wave = np.zeros((4000, 1, 3), np.float32)
    wave[:, 0] = np.sin(2 * np.pi * np.array([1.0, cutoff, 60.0]) * t[:, None])
    model = SensorModel(accelerometer=Triad(lowpass_hz=cutoff, lowpass_order=order), zero_phase=zero_phase)
    read = model.apply(ImuRecording(acc=wave, gyr=0 * wave, rate=rate), 0).acc[500:-500, 0]
    gain = read.std(axis=0) / wave[500:-500, 0].std(axis=0)
    assert gain[0] == pytest.approx(1, abs=0.01)
    assert gain[1] == pytest.approx(np.sqrt(0.5), abs=0.01)
    assert gain[2] < 0.35
    shifted = [np.corrcoef(read[:, 0], wave[500 - lag : -500 - lag, 0, 0])[0, 1] for lag in range(6)]
    assert bool(np.argmax(shifted) == 0) is zero_phase


@pytest.mark.parametrize("cutoff", [0.3, 0.4, 0.49])
def test_a_low_pass_near_half_the_rate_still_has_its_gain(cutoff):
    """In parts of the rate; by the bilinear transform a Butterworth filter's gain goes by tangents."""
    frequency = 0.45
    wave = np.zeros((4000, 1, 3), np.float32)
    wave[..., 0] = np.sin(2 * np.pi * frequency * np.arange(4000))[:, None]
    model = SensorModel(accelerometer=Triad(lowpass_of_rate=cutoff))
    read = model.apply(ImuRecording(acc=wave, gyr=0 * wave, rate=100.0), 0).acc
    ratio = np.tan(np.pi * frequency) / np.tan(np.pi * cutoff)
    gain = read[500:, 0, 0].std() / wave[500:, 0, 0].std()
    assert gain == pytest.approx(1 / np.sqrt(1 + ratio**4), abs=0.01)


def test_filters_start_at_rest_where_the_signal_does():
    model = SensorModel(accelerometer=Triad(lowpass_hz=5.0), soft_tissue_hz=8.0)
    np.testing.assert_allclose(model.apply(at_rest(100), 0).acc[:, 0, 2], G, rtol=1e-5)


def test_resampling_keeps_what_fits_and_stops_what_would_fold():
    rate = 200.0
    t = np.arange(2001) / rate
    wave = np.zeros((2001, 1, 3), np.float32)
    wave[:, 0] = np.sin(2 * np.pi * np.array([2.0, 8.0, 60.0]) * t[:, None])
    read = SensorModel(rate_hz=50.0).apply(ImuRecording(acc=wave, gyr=wave, rate=rate), 0)
    assert (read.n_samples, read.rate) == (501, 50.0)
    np.testing.assert_allclose(read.acc[20:-20, 0, :2], wave[::4][20:-20, 0, :2], atol=0.02)
    assert np.abs(read.acc[20:-20, 0, 2]).max() < 0.02


def test_range_and_steps():
    truth = moving()
    read = SensorModel(accelerometer=Triad(full_scale=6.0, resolution=0.25), gyroscope=Triad(full_scale=2.0))
    found = read.apply(truth, 0)
    np.testing.assert_allclose(found.acc, np.rint(np.clip(truth.acc, -6, 6) / 0.25) * 0.25)
    np.testing.assert_array_equal(found.gyr, np.clip(truth.gyr, -2, 2))


def test_samples_at_full_scale_are_counted_of_either_triad():
    part = SensorModel(
        accelerometer=Triad(full_scale=20.0, resolution=0.3), gyroscope=Triad(full_scale=4.0, resolution=0.01)
    )
    true = np.zeros((100, 2, 3), dtype=np.float32)
    acc, gyr = true.copy(), true.copy()
    acc[:5, 0, 1], gyr[3:8, 0, 2], gyr[50:52, 1, 0], acc[60:70, 1, 0] = -25.0, 9.0, -4.1, 19.5
    read = part.apply(ImuRecording(acc, gyr, 100.0), seed=0)
    assert part.at_full_scale(read) == pytest.approx((8 + 2) / 200)
    assert part.full_scale_content(read) == {"at_full_scale": 0.05}
    assert SensorModel.ideal().at_full_scale(read) == 0
    usual = replace(read, acc=0 * read.acc, gyr=np.where(np.arange(100)[:, None, None] < 1, 4, 0 * read.gyr))
    assert part.at_full_scale(usual) == 0.01
    assert part.full_scale_content(usual) == {}


def test_jitter_moves_the_sampling_instants():
    rate, jitter = 100.0, 0.002
    t = np.arange(20_000) / rate
    wave = np.zeros((20_000, 1, 3), np.float32)
    wave[:, 0, 0] = np.sin(2 * np.pi * 2 * t)
    read = SensorModel(jitter_s=jitter).apply(ImuRecording(acc=wave, gyr=wave, rate=rate), 0)
    error = (read.acc - wave)[:, 0, 0]
    slope = 2 * np.pi * 2 * np.cos(2 * np.pi * 2 * t)
    steep = np.abs(slope) > 10
    assert (error[steep] / slope[steep]).std() == pytest.approx(jitter, rel=0.03)
    np.testing.assert_array_equal(read.acc, read.gyr)


@pytest.mark.parametrize("duration", [0.0, 0.2])
def test_lost_samples_are_held_or_marked(duration):
    truth = moving(n_samples=40_000, n_sensors=2)
    lossy = SensorModel(drop_fraction=0.05, drop_duration_s=duration, dropped="nan").apply(truth, 0)
    lost = np.isnan(lossy.acc[..., 0])
    np.testing.assert_array_equal(lost, np.isnan(lossy.gyr[..., 2]))
    assert not lost[0].any()
    assert lost.mean() == pytest.approx(0.05, rel=0.2)
    runs = np.diff(np.flatnonzero(np.diff(lost[:, 0].astype(int))))[::2]
    assert runs.mean() == pytest.approx(max(1, duration * 100), rel=0.2)
    held = SensorModel(drop_fraction=0.05, drop_duration_s=duration).apply(truth, 0)
    last = np.maximum.accumulate(np.where(lost[:, 1], 0, np.arange(len(lost))))
    np.testing.assert_array_equal(held.acc[:, 1], truth.acc[last, 1])


def test_soft_tissue_rings_at_its_frequency_and_keeps_gravity():
    rate = 200.0
    thud = np.zeros((2000, 1, 3), np.float32)
    thud[..., 2] = G
    thud[1000, 0, 0] = 100
    read = SensorModel(soft_tissue_hz=10.0, soft_tissue_damping=0.1).apply(
        ImuRecording(acc=thud, gyr=0 * thud, rate=rate), 0
    )
    np.testing.assert_allclose(read.acc[:, 0, 2], G, rtol=1e-4)
    spectrum = np.abs(np.fft.rfft(read.acc[1000:, 0, 0]))
    assert np.fft.rfftfreq(1000, 1 / rate)[spectrum.argmax()] == pytest.approx(10, abs=0.4)
    half = SensorModel(soft_tissue_hz=10.0, soft_tissue_damping=0.1, soft_tissue_gain=0.5).apply(
        ImuRecording(acc=thud, gyr=0 * thud, rate=rate), 0
    )
    np.testing.assert_allclose(half.acc, (read.acc + thud) / 2, atol=1e-4)


def test_noise_belongs_to_the_sensor_not_to_its_company(monkeypatch):
    truth = moving(n_sensors=40)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    together = FULL.apply(truth, seed=11)
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    np.testing.assert_array_equal(FULL.apply(truth, seed=11).acc, together.acc)
    for numbers in (list(range(7)), list(range(7, 40)), [39, 3, 20]):
        part = replace(truth, acc=truth.acc[:, numbers], gyr=truth.gyr[:, numbers])
        alone = FULL.apply(part, 11, numbers)
        np.testing.assert_array_equal(alone.acc, together.acc[:, numbers])
        np.testing.assert_array_equal(alone.gyr, together.gyr[:, numbers])


def test_seeds_clips_and_sensors_each_have_noise_of_their_own():
    model = SensorModel(accelerometer=Triad(noise_density=0.1), gyroscope=Triad(noise_density=0.1))
    base = at_rest(2000, 2)
    one = model.apply(base, 1)
    others = [
        model.apply(base, 2).acc[:, 0, 0],
        model.apply(replace(base, clip="other"), 1).acc[:, 0, 0],
        one.acc[:, 1, 0],
        one.acc[:, 0, 1],
        one.gyr[:, 0, 0],
    ]
    for other in others:
        assert abs(np.corrcoef(one.acc[:, 0, 0], other)[0, 1]) < 0.1
    np.testing.assert_array_equal(model.apply(base, 1).acc, one.acc)


@pytest.mark.parametrize(
    "part",
    [
        {"turn_on_bias": 0.1},
        {"bias_instability": 0.1},
        {"random_walk": 0.1},
        {"scale_error": 0.1},
        {"misalignment_deg": 1.0},
    ],
)
def test_switching_a_part_on_leaves_the_other_random_numbers_alone(part):
    truth = at_rest(500)
    noise = SensorModel(accelerometer=Triad(noise_density=0.1)).apply(truth, 0).acc - truth.acc
    error = SensorModel(accelerometer=Triad(**part)).apply(truth, 0).acc - truth.acc
    both = SensorModel(accelerometer=Triad(noise_density=0.1, **part)).apply(truth, 0).acc - truth.acc
    np.testing.assert_allclose(both, noise + error, atol=1e-5)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_work_and_stay_within_their_datasheets(name):
    model = preset(name)
    assert model.name == name
    read = model.apply(at_rest(500, 64, 100), seed=0)
    assert np.isfinite(read.acc).all()
    worn = model.mounting_turn_deg > 0
    assert np.abs(np.linalg.norm(read.acc, axis=-1) - G).max() < 3
    if not worn:
        assert np.abs(read.acc.mean(axis=0) - [0, 0, G]).max() < 2
    if model.gyroscope.noise_density and not model.gyroscope.bandwidth(100.0):
        expected = model.gyroscope.noise_density * np.sqrt(50)
        assert read.gyr.std(axis=0).mean() == pytest.approx(expected, rel=0.05)


def test_presets_are_found_however_they_are_spelt():
    assert preset("MPU 6050") is preset("mpu-6050") is preset("MPU6050")
    assert preset(DEFAULT_SENSOR).name == "bmi270"
    assert preset("Xsens MTw Awinda").accelerometer.full_scale == 160
    with pytest.raises(ValueError, match="no sensor preset 'adxl345'; choose one of ideal, bmi270"):
        preset("adxl345")


@pytest.mark.parametrize("name", [f.name for f in fields(Triad)])
def test_triads_are_checked_at_the_door(name):
    with pytest.raises(ValueError, match=name):
        Triad(**{name: -1})


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"drop_fraction": 1.0}, "drop_fraction"),
        ({"soft_tissue_gain": 1.5}, "soft_tissue_gain"),
        ({"dropped": "zero"}, "dropped"),
        ({"jitter_s": -0.1}, "jitter_s"),
        ({"rate_hz": 0.0}, "rate_hz"),
        ({"mounting_turn_deg": float("nan")}, "mounting_turn_deg"),
    ],
)
def test_models_are_checked_at_the_door(change, named):
    with pytest.raises(ValueError, match=named):
        SensorModel(**change)


def test_seeds_are_checked():
    with pytest.raises(ValueError, match="must not be negative"):
        SensorModel().apply(at_rest(10), seed=-1)


@pytest.mark.parametrize("n_samples", [1, 2, 3, 10])
def test_the_shortest_recordings(n_samples):
    assert FULL.apply(at_rest(n_samples, 2, 100), 0).n_samples == n_samples
