# SPDX-License-Identifier: GPL-3.0-or-later
"""Synthesis against analytic truth, its order of convergence, and awkward clips."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import solve_ivp, trapezoid
from scipy.spatial.transform import Rotation

from w2w.core.imu.synthesis import STANDARD_GRAVITY, Synthesis, synthesize
from w2w_studies.paper.differences import synthesize_by_differences

UP = np.array([0, 0, STANDARD_GRAVITY])
EXACT = Synthesis(rate_hz=100, cutoff_hz=None)
FLOAT32 = 1e-5
METHODS = [synthesize, synthesize_by_differences]


def poses(rotations: Rotation, positions: np.ndarray) -> np.ndarray:
    """World matrices (T, 1, 4, 4) of one sensor."""
    matrices = np.zeros((len(positions), 1, 4, 4))
    matrices[:, 0, :3, :3] = np.broadcast_to(rotations.as_matrix(), (len(positions), 3, 3))
    matrices[:, 0, :3, 3] = positions
    matrices[:, 0, 3, 3] = 1
    return matrices


def times(duration: float, rate: float) -> np.ndarray:
    return np.arange(round(duration * rate) + 1) / rate


def about_z(angles: np.ndarray) -> Rotation:
    return Rotation.from_rotvec(np.multiply.outer(angles, [0, 0, 1.0]))


class Wave:
    """A smooth band-limited motion whose derivatives are known in closed form."""

    def __init__(self, seed: int, highest_hz: float = 3.0) -> None:
        rng = np.random.default_rng(seed)
        self.omega = 2 * np.pi * rng.uniform(0.2, highest_hz, (6, 4))
        self.phase = rng.uniform(0, 2 * np.pi, (6, 4))
        self.size = rng.uniform(0.2, 1.0, (6, 4)) / self.omega * 3

    def __call__(self, t: np.ndarray, order: int) -> np.ndarray:
        angle = self.omega * t[:, None, None] + self.phase + order * np.pi / 2
        return (self.size * self.omega**order * np.sin(angle)).sum(axis=-1)

    def matrices(self, t: np.ndarray) -> np.ndarray:
        values = self(t, 0)
        return poses(Rotation.from_rotvec(values[:, 3:]), values[:, :3])

    def signals(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Specific force, and angular velocity by the right Jacobian of the rotation vector."""
        rotvec, rate = self(t, 0)[:, 3:], self(t, 1)[:, 3:]
        force = Rotation.from_rotvec(rotvec).inv().apply(self(t, 2)[:, :3] + UP)
        angle = np.linalg.norm(rotvec, axis=1, keepdims=True)
        turned = np.cross(rotvec, rate)
        spin = rate - (1 - np.cos(angle)) / angle**2 * turned
        return force, spin + (angle - np.sin(angle)) / angle**3 * np.cross(rotvec, turned)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_at_rest_it_reads_gravity_along_up(seed):
    turn = Rotation.random(random_state=seed)
    recording = synthesize(poses(turn, np.tile([3.0, -8, 1], (40, 1))), 30)
    np.testing.assert_allclose(recording.acc[:, 0], np.tile(turn.inv().apply(UP), (66, 1)), atol=FLOAT32)
    assert np.all(recording.gyr == 0)


@pytest.mark.parametrize("method", METHODS)
def test_in_free_fall_it_reads_nothing_however_it_spins(method):
    t = times(2, 60)
    fall = np.array([1.0, 2, 5]) * t[:, None] - 0.5 * UP * t[:, None] ** 2
    turn = about_z(1.3 * t) * Rotation.from_euler("xyz", [0.4, -1, 2])
    recording = method(poses(turn, fall), 60, EXACT)
    assert np.abs(recording.acc).max() < 1e-4


def test_smoothing_leaves_free_fall_alone():
    t = times(2, 60)
    fall = np.array([1.0, 2, 5]) * t[:, None] - 0.5 * UP * t[:, None] ** 2
    assert np.abs(synthesize(poses(Rotation.identity(), fall), 60).acc).max() < 1e-4


@pytest.mark.parametrize("cutoff_hz", [None, 10.0])
def test_constant_spin(cutoff_hz):
    rate, omega, radius = 120, 2 * np.pi * 1.5, 0.3
    t = times(3, rate)
    outward = np.stack([np.cos(omega * t), np.sin(omega * t), np.zeros_like(t)], axis=1)
    recording = synthesize(
        poses(about_z(omega * t), radius * outward), rate, Synthesis(rate_hz=100, cutoff_hz=cutoff_hz)
    )
    middle = slice(30, -30)
    np.testing.assert_allclose(recording.gyr[middle, 0], np.tile([0, 0, omega], (241, 1)), atol=1e-4)
    centripetal = np.tile([-radius * omega**2, 0, STANDARD_GRAVITY], (241, 1))
    np.testing.assert_allclose(recording.acc[middle, 0], centripetal, atol=1e-3)


def test_a_free_pendulum_feels_nothing_along_its_path():
    """Gravity and inertia cancel along the arc, and energy fixes the pull: 3 g cos - 2 g cos of the start."""
    length, start, rate = 0.6, 1.2, 100
    t = times(3, rate)
    swing = solve_ivp(
        lambda _, y: [y[1], -STANDARD_GRAVITY / length * np.sin(y[0])],
        (0, 3),
        [start, 0],
        t_eval=t,
        rtol=1e-12,
        atol=1e-12,
    )
    angle, spin = swing.y
    bob = length * np.stack([np.sin(angle), np.zeros_like(t), -np.cos(angle)], axis=1)
    turn = Rotation.from_rotvec(np.multiply.outer(-angle, [0, 1.0, 0]))
    recording = synthesize(poses(turn, bob), rate, EXACT)
    pull = STANDARD_GRAVITY * (3 * np.cos(angle) - 2 * np.cos(start))
    inside = slice(10, -10)
    np.testing.assert_allclose(recording.acc[inside, 0, 0], 0, atol=2e-4)
    np.testing.assert_allclose(recording.acc[inside, 0, 2], pull[inside], atol=2e-4)
    np.testing.assert_allclose(recording.gyr[inside, 0, 1], -spin[inside], atol=2e-4)


def test_screw_motion():
    rate, omega, pitch, radius = 100, 4.0, 0.25, 0.2
    axis = np.array([1.0, 2, 2]) / 3
    t = times(4, rate)
    tilt = Rotation.align_vectors([axis], [[0, 0, 1.0]])[0]
    helix = np.stack([radius * np.cos(omega * t), radius * np.sin(omega * t), pitch * omega * t], axis=1)
    turn = tilt * about_z(omega * t)
    recording = synthesize(poses(turn, tilt.apply(helix)), rate, EXACT)
    inside = slice(10, -10)
    np.testing.assert_allclose(recording.gyr[inside, 0], np.tile([0, 0, omega], (381, 1)), atol=1e-4)
    expected = np.array([-radius * omega**2, 0, 0]) + turn.inv().apply(UP)
    np.testing.assert_allclose(recording.acc[inside, 0], expected[inside], atol=1e-3)


def test_sensor_on_the_rim_of_a_rolling_wheel():
    """The rim's path is a cycloid, yet in its own axes the sensor feels the spin alone."""
    rate, omega, radius = 120, 6.0, 0.35
    t = times(3, rate)
    angle = omega * t
    rim = radius * np.stack([angle + np.sin(angle), np.zeros_like(t), 1 + np.cos(angle)], axis=1)
    turn = Rotation.from_rotvec(np.multiply.outer(angle, [0, 1.0, 0]))
    recording = synthesize(poses(turn, rim), rate, EXACT)
    inside = slice(10, -10)
    expected = np.array([0, 0, -radius * omega**2]) + turn.inv().apply(UP)
    at = np.round(recording.time * rate).astype(int)
    whole = np.abs(recording.time * rate - at) < 1e-9
    np.testing.assert_allclose(recording.acc[whole, 0][inside], expected[at[whole]][inside], atol=1e-3)
    np.testing.assert_allclose(recording.gyr[inside, 0, 1], omega, atol=1e-4)


@given(
    seed=st.integers(0, 1000),
    yaw=st.floats(-np.pi, np.pi),
    shift=st.floats(-100, 100),
    speed=st.floats(-5, 5),
    method=st.sampled_from(METHODS),
)
@settings(max_examples=40, deadline=None)
def test_neither_yaw_nor_place_nor_steady_drift_of_the_world_matters(seed, yaw, shift, speed, method):
    t = times(1.5, 60)
    matrices = Wave(seed).matrices(t)
    world = np.eye(4)
    world[:3, :3] = about_z(yaw).as_matrix()
    moved = world @ matrices
    moved[:, 0, :3, 3] += shift + speed * t[:, None]
    here, there = (method(m, 60, Synthesis()) for m in (matrices, moved))
    np.testing.assert_allclose(here.acc, there.acc, atol=2e-4)
    np.testing.assert_allclose(here.gyr, there.gyr, atol=2e-4)


@given(st.integers(0, 1000))
@settings(max_examples=20, deadline=None)
def test_turning_the_sensor_on_its_carrier_turns_what_it_reads(seed):
    matrices = Wave(seed).matrices(times(1.5, 60))
    mounting = Rotation.random(random_state=seed)
    turned = matrices.copy()
    turned[..., :3, :3] = matrices[..., :3, :3] @ mounting.as_matrix()
    plain, other = synthesize(matrices, 60), synthesize(turned, 60)
    np.testing.assert_allclose(other.acc[:, 0], mounting.inv().apply(plain.acc[:, 0]), atol=1e-4)
    np.testing.assert_allclose(other.gyr[:, 0], mounting.inv().apply(plain.gyr[:, 0]), atol=1e-4)


@pytest.mark.parametrize(("method", "order"), [(synthesize, 4), (synthesize_by_differences, 2)])
def test_the_error_falls_with_the_frame_rate_as_promised(method, order):
    wave = Wave(3)
    rates = [20, 40, 80]
    errors = []
    for rate in rates:
        recording = method(wave.matrices(times(4, rate)), rate, Synthesis(rate_hz=20, cutoff_hz=None))
        force, spin = wave.signals(recording.time)
        inside = slice(15, -15)
        errors.append(
            [
                np.abs(recording.acc[:, 0] - force)[inside].max(),
                np.abs(recording.gyr[:, 0] - spin)[inside].max(),
            ]
        )
    slopes = -np.diff(np.log2(errors), axis=0)
    assert slopes.mean(axis=0).min() > order - 0.4, errors
    assert errors[-1][0] < {4: 0.01, 2: 1.0}[order]


@pytest.mark.parametrize("sample_rate", [25.0, 50.0, 64.0, 99.7, 200.0])
@pytest.mark.parametrize("frame_rate", [24, 30000 / 1001, 60, 120])
def test_signals_do_not_depend_on_how_the_rates_meet(frame_rate, sample_rate):
    wave = Wave(8, highest_hz=1.5)
    recording = synthesize(
        wave.matrices(np.arange(int(4 * frame_rate)) / frame_rate),
        frame_rate,
        Synthesis(rate_hz=sample_rate, cutoff_hz=None),
    )
    assert recording.n_samples == int((int(4 * frame_rate) - 1) / frame_rate * sample_rate + 1e-6) + 1
    force, spin = wave.signals(recording.time)
    inside = (recording.time > 0.5) & (recording.time < 3.3)
    np.testing.assert_allclose(recording.acc[inside, 0], force[inside], atol=0.05)
    np.testing.assert_allclose(recording.gyr[inside, 0], spin[inside], atol=0.01)


@pytest.mark.parametrize("cutoff_hz", [3.0, 6.0, 12.0])
@pytest.mark.parametrize("rate", [60, 120])
def test_the_band_limit_stands_where_it_says(cutoff_hz, rate):
    t = times(8, rate)
    wave = np.zeros((len(t), 3))
    wave[:, 0] = np.sin(2 * np.pi * cutoff_hz * t)
    matrices = poses(Rotation.identity(), wave)
    limited, free = (
        synthesize(matrices, rate, Synthesis(rate_hz=100, cutoff_hz=limit)).acc[200:600, 0, 0]
        for limit in (cutoff_hz, None)
    )
    assert limited.std() / free.std() == pytest.approx(np.sqrt(0.5), abs=0.01)


def test_jitter_of_motion_capture_stays_out():
    """White jitter of 0.5 mm: what is left is what the pass band lets through, at any frame rate."""
    rng = np.random.default_rng(0)
    f = np.linspace(0, 60, 6000)
    gain = (2 * np.pi * f) ** 2 / (1 + (np.sqrt(2) - 1) * (f / 10) ** 6)
    levels = {}
    for rate in (60, 120, 240):
        still = rng.normal(0, 0.0005, (20 * rate, 3))
        recording = synthesize(poses(Rotation.identity(), still), rate, Synthesis(rate_hz=100))
        density = 0.0005 * np.sqrt(2 / rate)
        levels[rate] = recording.acc[100:-100, 0, 0].std() / (density * np.sqrt(trapezoid(gain**2, f)))
    assert levels[120] == pytest.approx(1, abs=0.15)
    assert levels[240] == pytest.approx(1, abs=0.15)
    assert levels[60] < 1.3


def test_ends_stay_calm_under_jitter():
    """A spline is free at its ends; smoothing must not let noise whip there."""
    rng = np.random.default_rng(2)
    ends, middle = [], []
    for _ in range(30):
        still = rng.normal(0, 0.0005, (120, 3))
        acc = synthesize(poses(Rotation.identity(), still), 60).acc[:, 0, 0]
        ends.append(acc[[0, -1]])
        middle.append(acc[20:-20])
    assert np.std(ends) < 3 * np.std(middle)


def test_all_sensors_at_once_equal_one_at_a_time(monkeypatch):
    t = times(3, 30)
    matrices = np.concatenate([Wave(seed).matrices(t) for seed in range(300)], axis=1)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    together = synthesize(matrices, 30)
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    assert np.array_equal(synthesize(matrices, 30).acc, together.acc)
    for sensor in (0, 77, 299):
        alone = synthesize(matrices[:, sensor : sensor + 1], 30)
        np.testing.assert_allclose(alone.acc[:, 0], together.acc[:, sensor], atol=1e-4)
        np.testing.assert_allclose(alone.gyr[:, 0], together.gyr[:, sensor], atol=1e-5)


def test_the_papers_equations_as_printed():
    """World-frame acceleration plus turned gravity, and the rate in the world frame."""
    wave = Wave(9, highest_hz=1.5)
    t = times(4, 120)
    for method in METHODS:
        recording = method(wave.matrices(t), 120, Synthesis(rate_hz=60, convention="paper", cutoff_hz=None))
        turn = Rotation.from_rotvec(wave(recording.time, 0)[:, 3:])
        inside = slice(10, -10)
        expected = wave(recording.time, 2)[:, :3] - turn.inv().apply(UP)
        np.testing.assert_allclose(recording.acc[inside, 0], expected[inside], atol=0.1)
        # the printed difference reaches one frame back, so it is half a frame late
        late = 0.0 if method == synthesize else 0.5 / 120
        at = recording.time - late
        spin = Rotation.from_rotvec(wave(at, 0)[:, 3:]).apply(wave.signals(at)[1])
        np.testing.assert_allclose(recording.gyr[inside, 0], spin[inside], atol=0.02)
