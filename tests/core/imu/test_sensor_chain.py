# SPDX-License-Identifier: GPL-3.0-or-later
"""The order of the sensor's parts, their signs and their orders, against closed forms."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import welch
from scipy.spatial.transform import Rotation

from w2w.core.imu import errors
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel, Triad

RATE = 200.0


def recorded(acc, gyr=None, rate=RATE) -> ImuRecording:
    acc = np.asarray(acc, dtype=np.float32)
    return ImuRecording(acc=acc, gyr=np.zeros_like(acc) if gyr is None else np.float32(gyr), rate=rate)


def sines(frequencies, n_samples=4000, rate=RATE):
    """One sensor, a sine of unit amplitude on each axis."""
    t = np.arange(n_samples)[:, None, None] / rate
    return np.sin(2 * np.pi * np.array(frequencies) * t).astype(np.float32)


def amplitude(values, frequency, rate=RATE):
    """Amplitude of a frequency in (T,) values over whole periods of it."""
    t = np.arange(len(values)) / rate
    return 2 * np.abs((values * np.exp(-2j * np.pi * frequency * t)).mean())


def gain(frequency, cutoff, order, zero_phase=False, rate=RATE):
    """Butterworth's, on the frequency axis that the bilinear transform bends."""
    bent = (np.tan(np.pi * frequency / rate) / np.tan(np.pi * cutoff / rate)) ** (2 * order)
    return 1 / (1 + (np.sqrt(2) - 1) * bent) if zero_phase else 1 / np.sqrt(1 + bent)


@pytest.mark.parametrize("zero_phase", [False, True])
@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("kind", ["accelerometer", "gyroscope"])
def test_the_low_pass_falls_off_by_its_order(kind, order, zero_phase):
    """Half, twice and four times the cut-off: 6 dB an octave and order."""
    frequencies = (5.0, 20.0, 40.0)
    wave = sines(frequencies)
    model = SensorModel(**{kind: Triad(lowpass_hz=10.0, lowpass_order=order)}, zero_phase=zero_phase)
    read = model.apply(recorded(wave, wave), seed=0)
    filtered, other = (read.acc, read.gyr) if kind == "accelerometer" else (read.gyr, read.acc)
    for axis, frequency in enumerate(frequencies):
        found = amplitude(filtered[2000:3000, 0, axis].astype(float), frequency)
        assert found == pytest.approx(gain(frequency, 10, order, zero_phase), rel=0.01, abs=2e-5)
    np.testing.assert_array_equal(other, wave)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_noise_goes_through_the_low_pass(order):
    """Inside the band it has its density, beyond it falls as the filter does."""
    density, cutoff = 0.01, 12.5
    model = SensorModel(gyroscope=Triad(noise_density=density, lowpass_hz=cutoff, lowpass_order=order))
    noise = model.apply(recorded(np.zeros((60_000, 4, 3))), seed=1).gyr.reshape(60_000, -1)
    frequencies, power = welch(noise, fs=RATE, nperseg=512, axis=0)
    power = power.mean(axis=1)
    expected = density**2 * gain(frequencies, cutoff, order) ** 2
    inside = (frequencies > 1) & (frequencies < 60)
    np.testing.assert_allclose(power[inside], expected[inside], rtol=0.25)
    assert power[inside].sum() == pytest.approx(expected[inside].sum(), rel=0.03)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_noise_that_folds_in_is_that_of_the_filters_order(order):
    model = SensorModel(accelerometer=Triad(noise_density=0.01, lowpass_hz=100.0, lowpass_order=order))
    noise = model.apply(recorded(np.zeros((20_000, 2, 3)), rate=50.0), seed=0).acc
    # the analogue filter's |H|^2 = 1 / (1 + (f / fc)^2n), integrated over all frequencies
    bandwidth = 100 * quad(lambda x: 1 / (1 + x ** (2 * order)), 0, np.inf)[0]
    assert noise.std() == pytest.approx(0.01 * np.sqrt(bandwidth), rel=0.01)


def test_a_bandwidth_told_as_a_part_of_the_rate_is_one_of_the_output_rate():
    model = SensorModel(accelerometer=Triad(lowpass_of_rate=0.2, lowpass_order=2), rate_hz=50.0)
    read = model.apply(recorded(sines((10.0, 5.0, 2.0))), seed=0)
    for axis, frequency in enumerate((10.0, 5.0, 2.0)):
        found = amplitude(read.acc[500:750, 0, axis].astype(float), frequency, rate=50.0)
        assert found == pytest.approx(gain(frequency, 10.0, 2), rel=0.02)


def test_a_turned_sensor_reads_the_world_turned_back():
    """A sensor a quarter turn about its z: what pushed along x pushes along its -y."""
    quarter = np.array([[0, 0, np.pi / 2]])
    acc, gyr = errors.mount(
        np.float32([[[1], [0], [0]]]), np.float32([[[0], [1], [0]]]), RATE, quarter, np.zeros((1, 3))
    )
    np.testing.assert_allclose(acc[0, :, 0], [0, -1, 0], atol=1e-6)
    np.testing.assert_allclose(gyr[0, :, 0], [1, 0, 0], atol=1e-6)


def test_the_lever_arm_pulls_inwards_and_pushes_with_the_turn():
    """A shift r in a frame that spins by w(t): w' x r + w x (w x r), then the sensor's own turn."""
    t = np.arange(400) / RATE
    axis = np.array([0.36, 0.48, 0.8])
    spin, push = 2 + 3 * t, 3.0
    shift, turn = np.array([0.1, -0.05, 0.2]), np.array([0.3, -0.2, 0.5])
    acc, gyr = errors.mount(
        np.zeros((1, 3, 400), np.float32),
        (axis[:, None] * spin)[None].astype(np.float32),
        RATE,
        turn[None],
        shift[None],
    )
    expected = (
        np.cross(push * axis, shift)[:, None] + np.cross(axis, np.cross(axis, shift))[:, None] * spin**2
    )
    back = Rotation.from_rotvec(turn).inv()
    np.testing.assert_allclose(acc[0, :, 1:-1].T, back.apply(expected.T)[1:-1], atol=2e-3)
    np.testing.assert_allclose(gyr[0].T, back.apply((axis[:, None] * spin).T), atol=1e-5)


def test_axes_lean_turn_and_stretch_as_documented():
    """Rows of the matrix are the axes that read: scale by row, y leans to x, z to x and to y."""
    zero, one = np.zeros((1, 3)), np.array([[0.1, 0.2, 0.3]])
    lean = errors.axes_matrix(zero, zero, one)[0]
    expected = np.eye(3)
    expected[1, 0], expected[2, 0], expected[2, 1] = np.sin([0.1, 0.2, 0.3])
    np.testing.assert_allclose(lean, expected)
    turned = errors.axes_matrix(zero, np.array([[0, 0, np.pi / 2]]), zero)[0]
    np.testing.assert_allclose(turned @ [1, 0, 0], [0, -1, 0], atol=1e-12)
    scaled = errors.axes_matrix(one, zero, one)[0]
    np.testing.assert_allclose(scaled, np.diag([1.1, 1.2, 1.3]) @ expected)
    # the case's vector is turned into the triad first, then read by axes that lean
    both = errors.axes_matrix(zero, np.array([[0, 0, np.pi / 2]]), one)[0]
    np.testing.assert_allclose(both, expected @ turned, atol=1e-12)


def test_constant_errors_are_drawn_in_degrees():
    """Of 3,000 sensors: the spread of the angle by which z leans, and by which all turn."""
    push = np.zeros((1, 3000, 3))
    push[..., 0] = 1
    lean = SensorModel(accelerometer=Triad(nonorthogonality_deg=2.0)).apply(recorded(push), 0).acc[0]
    np.testing.assert_array_equal(lean[:, 0], 1)
    np.testing.assert_allclose(np.degrees(np.arcsin(lean[:, 1:])).std(axis=0), 2.0, rtol=0.04)
    turned = SensorModel(accelerometer=Triad(misalignment_deg=2.0)).apply(recorded(push), 0).acc[0]
    np.testing.assert_allclose(np.degrees(np.arcsin(turned[:, 1:])).std(axis=0), 2.0, rtol=0.04)
    worn = SensorModel(mounting_turn_deg=3.0).apply(recorded(push), 0).acc[0]
    np.testing.assert_allclose(np.degrees(np.arcsin(worn[:, 1:])).std(axis=0), 3.0, rtol=0.04)


def test_a_gyroscope_feels_what_pushes_the_accelerometer_as_worn():
    """The response is to the specific force on the sensor's own axes, and one row an axis."""
    push = np.zeros((3, 1, 3))
    push[np.arange(3), 0, np.arange(3)] = 10.0  # along x, then y, then z
    felt = SensorModel(g_sensitivity=0.01).apply(recorded(push), seed=4).gyr[:, 0]
    numbers = errors.SensorStreams(4, "", range(1)).constants("g-sensitivity", 3, 3)[0]
    np.testing.assert_allclose(felt.T, 0.1 * numbers, rtol=1e-5)
    model = SensorModel(g_sensitivity=0.01, mounting_turn_deg=30.0)
    worn = model.apply(recorded(push), seed=4)
    np.testing.assert_allclose(worn.gyr[:, 0], worn.acc[:, 0] @ (0.01 * numbers.T), atol=1e-5)


def test_jitter_reads_a_parabola_where_it_says():
    """Later for positive offsets, exact for parabolas, within half an interval, ends left alone."""
    t = np.arange(50.0)
    offsets = np.random.default_rng(0).uniform(-0.9, 0.9, (1, 50))
    found = errors.jitter((2 + 3 * t - 0.1 * t**2)[None, None], offsets)[0, 0]
    at = t + np.clip(offsets[0], -0.5, 0.5) * ((t > 0) & (t < 49))
    np.testing.assert_allclose(found, 2 + 3 * at - 0.1 * at**2, atol=1e-9)


def test_a_bias_is_in_its_steady_state_from_the_start():
    numbers = np.random.default_rng(0).normal(size=(4000, 2, 3, 60)).astype(np.float32)
    drift = errors.bias_drift(numbers, deviation=0.5, correlation_s=1.0, walk_density=0.0)
    np.testing.assert_allclose(drift.std(axis=(0, 1)), 0.5, rtol=0.04)
    lag = int(1.0 / errors.DRIFT_STEP_S)
    correlation = (drift[..., :-lag] * drift[..., lag:]).mean() / drift.var()
    assert correlation == pytest.approx(np.exp(-1), abs=0.02)


@pytest.mark.parametrize("frequency", [4.0, 10.0, 25.0])
def test_soft_tissue_passes_what_a_spring_and_damper_do(frequency):
    """|2 z w s + w^2| / |s^2 + 2 z w s + w^2|, both triads alike; w and f where the transform bends them."""
    wave = sines((frequency,) * 3)
    natural, damping = 10.0, 0.2
    read = SensorModel(soft_tissue_hz=natural, soft_tissue_damping=damping).apply(recorded(wave, 2 * wave), 0)
    s = 1j * np.tan(np.pi * frequency / RATE) / np.tan(np.pi * natural / RATE)
    expected = abs((2 * damping * s + 1) / (s**2 + 2 * damping * s + 1))
    assert amplitude(read.acc[2000:3000, 0, 0].astype(float), frequency) == pytest.approx(expected, rel=2e-3)
    np.testing.assert_allclose(read.gyr, 2 * read.acc, atol=1e-5)


def test_tissue_counts_as_stiff_from_half_the_rate_only():
    wave = sines((20.0, 30.0, 40.0))
    for natural, moved in ((99.0, True), (100.0, False)):
        read = SensorModel(soft_tissue_hz=natural).apply(recorded(wave), 0)
        assert bool((read.acc != wave).any()) is moved


@pytest.mark.parametrize(("fraction", "length_s"), [(0.3, 0.0), (0.3, 0.05), (0.6, 0.1)])
def test_the_share_of_lost_samples_holds_for_large_losses(fraction, length_s):
    model = SensorModel(drop_fraction=fraction, drop_duration_s=length_s, dropped="nan")
    lost = np.isnan(model.apply(recorded(np.zeros((40_000, 4, 3))), 0).acc[..., 0])
    assert lost.mean() == pytest.approx(fraction, rel=0.04)
    runs = [np.diff(np.flatnonzero(np.diff(column.astype(int))))[::2] for column in lost.T]
    assert np.concatenate(runs).mean() == pytest.approx(max(1.0, length_s * RATE), rel=0.05)
