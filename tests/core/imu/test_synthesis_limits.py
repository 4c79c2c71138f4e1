# SPDX-License-Identifier: GPL-3.0-or-later
"""What synthesis makes of awkward clips: short, broken, repeated; and of wrong settings."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.imu.synthesis import STANDARD_GRAVITY, Synthesis, synthesize

from .test_synthesis import EXACT, METHODS, UP, Wave, about_z, poses, times


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n_frames", [3, 4, 5, 6, 7])
def test_the_shortest_clips(n_frames, method):
    t = np.arange(n_frames) / 30
    fall = -0.5 * UP * t[:, None] ** 2
    for setting in (EXACT, Synthesis()):
        recording = method(poses(about_z(0.5 * t), fall), 30, setting)
        assert recording.n_samples == int((n_frames - 1) / 30 * setting.rate_hz + 1e-6) + 1
        assert np.abs(recording.acc).max() < 1e-3
        np.testing.assert_allclose(recording.gyr[:, 0, 2], 0.5, atol=2e-3)


@pytest.mark.parametrize("n_frames", [1, 2])
def test_too_few_frames_are_refused(n_frames):
    with pytest.raises(ValueError, match=rf"at least 3 frames .* not {n_frames}"):
        synthesize(poses(Rotation.identity(), np.zeros((n_frames, 3))), 30)


def test_many_turns_about_a_wandering_axis():
    """Quaternions pass through every sign and w = 0 on the way."""
    rate = 60
    t = times(6, rate)
    turn = about_z(0.9 * t) * Rotation.from_rotvec(np.multiply.outer(5 * t, [1.0, 0, 0]))
    recording = synthesize(poses(turn, np.zeros((len(t), 3))), rate, EXACT)
    at = recording.time
    expected = np.stack([np.full_like(at, 5), 0.9 * np.sin(5 * at), 0.9 * np.cos(5 * at)], axis=1)
    np.testing.assert_allclose(recording.gyr[20:-20, 0], expected[20:-20], atol=1e-3)


def test_half_turns_from_frame_to_frame_do_not_break():
    turn = Rotation.from_rotvec(np.multiply.outer(np.arange(30) * np.pi, [0, 1.0, 0]))
    recording = synthesize(poses(turn, np.zeros((30, 3))), 30)
    assert np.isfinite(recording.acc).all()
    assert np.isfinite(recording.gyr).all()


def test_noisy_frames_of_a_sliver_triangle_still_give_finite_rates():
    rng = np.random.default_rng(5)
    shaken = Rotation.from_rotvec(rng.normal(0, 0.05, (120, 3)))
    recording = synthesize(poses(shaken, np.zeros((120, 3))), 60)
    assert np.abs(np.linalg.norm(recording.acc[:, 0], axis=1) - STANDARD_GRAVITY).max() < 1e-3
    assert recording.gyr.std() < 1.5


@pytest.mark.parametrize("flaw", ["scale", "reflection", "shear"])
def test_matrices_that_are_no_rigid_motion_are_refused(flaw):
    matrices = poses(Rotation.random(50, random_state=1), np.zeros((50, 3)))
    change = {
        "scale": np.diag([0.01] * 3),
        "reflection": np.diag([-1.0, 1, 1]),
        "shear": np.eye(3) + np.diag([0.3, 0], 1)[:3, :3],
    }
    matrices[7, 0, :3, :3] = matrices[7, 0, :3, :3] @ change[flaw]
    with pytest.raises(ValueError, match="sensor 0 in frame 7 is not a rigid motion"):
        synthesize(matrices, 60)


def test_messages_name_the_sensor_by_its_place_among_all():
    matrices = np.repeat(poses(Rotation.identity(), np.zeros((30, 3))), 300, axis=1)
    matrices[4, 290, :3, :3] *= 2
    with pytest.raises(ValueError, match="sensor 290 in frame 4"):
        synthesize(matrices, 30)
    matrices[4, 290] = np.eye(4)
    matrices[5:20, 299] = np.nan
    with pytest.raises(ValueError, match="sensor 299 has no pose"):
        synthesize(matrices, 30)


def test_gaps_are_bridged():
    wave = Wave(4, highest_hz=1.5)
    matrices = np.repeat(wave.matrices(times(3, 60)), 3, axis=1)
    holed = matrices.copy()
    holed[60:66, 0] = np.nan
    holed[100, 1, :3, 3] = np.nan
    holed[101:104, 2, 0, 0] = np.nan
    whole, bridged = synthesize(matrices, 60), synthesize(holed, 60)
    np.testing.assert_allclose(bridged.acc, whole.acc, atol=1.0)
    np.testing.assert_allclose(bridged.gyr, whole.gyr, atol=0.1)
    far = np.r_[0:20, 110:150]
    np.testing.assert_allclose(bridged.acc[far], whole.acc[far], atol=1e-2)


@pytest.mark.parametrize(
    ("hole", "message"),
    [
        (slice(0, 3), "sensor 1 has no pose from 0.00 s to 0.05 s, at the clip's edge"),
        (slice(170, 181), "at the clip's edge"),
        (slice(60, 90), r"from 1.00 s to 1.50 s, longer than max_gap_s = 0.25"),
    ],
)
def test_gaps_that_cannot_be_bridged_are_named(hole, message):
    matrices = np.repeat(Wave(4).matrices(times(3, 60)), 2, axis=1)
    matrices[hole, 1] = np.nan
    with pytest.raises(ValueError, match=message):
        synthesize(matrices, 60)


def test_repeated_frames_are_not_read_as_stops():
    """24 to 30 fps by repeating one frame in five; and animation on twos."""
    wave = Wave(6, highest_hz=1.0)
    for held, rate in (
        (np.arange(150) // 5 * 5 + np.minimum(np.arange(150) % 5, 3), 30),
        (np.arange(240) // 2 * 2, 60),
    ):
        recording = synthesize(wave.matrices(held / rate), rate)
        smooth = synthesize(wave.matrices(np.arange(len(held)) / rate), rate)
        inside = slice(10, -15)
        assert np.abs(recording.acc[inside] - smooth.acc[inside]).max() < 0.3
        assert np.abs(recording.gyr[inside] - smooth.gyr[inside]).max() < 0.1


def test_a_real_rest_is_left_alone():
    t = times(4, 60)
    path = np.zeros((len(t), 3))
    path[:, 0] = np.clip(t - 2, 0, None) ** 3
    recording = synthesize(poses(Rotation.identity(), path), 60, EXACT)
    np.testing.assert_allclose(recording.acc[:190, 0], np.tile(UP, (190, 1)), atol=1e-4)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"rate_hz": 0}, "rate_hz"),
        ({"rate_hz": float("nan")}, "rate_hz"),
        ({"convention": "printed"}, "convention"),
        ({"cutoff_hz": -1}, "cutoff_hz"),
        ({"gravity": (0, 0)}, "gravity"),
        ({"max_gap_s": -1}, "max_gap_s"),
    ],
)
def test_settings_are_checked_at_the_door(change, named):
    with pytest.raises(ValueError, match=named):
        Synthesis(**change)


def test_wrong_shapes_and_rates_are_refused():
    with pytest.raises(ValueError, match=r"\(T, N, 4, 4\), not \(10, 4, 4\)"):
        synthesize(np.zeros((10, 4, 4)), 30)
    with pytest.raises(ValueError, match="frame rate must be positive"):
        synthesize(poses(Rotation.identity(), np.zeros((10, 3))), 0)
