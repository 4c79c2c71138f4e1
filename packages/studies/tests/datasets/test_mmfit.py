# SPDX-License-Identifier: GPL-3.0-or-later
"""MM-Fit's files, made as its tools describe them, come in on one clock and in SI units."""

import numpy as np
import pytest

from w2w_studies.datasets import mmfit
from w2w_studies.datasets.mmfit import CAMERA_RATE, RATE_HZ, guessed_unit, read_labels, read_mmfit

G = 9.80665
N_FRAMES = 600


def write_stream(path, rate, signal, first_ms=5000.0, offset_s=0.0):
    """A device's file: whole frame numbers, its own milliseconds, and a signal of camera time."""
    seconds = np.arange(0, N_FRAMES / CAMERA_RATE, 1 / rate)
    frame = np.round((seconds + offset_s) * CAMERA_RATE)
    np.save(path, np.column_stack([frame, first_ms + 1000 * seconds, signal(seconds + offset_s)]))


def wave(scale=1.0, rest=(0, 0, 0)):
    return lambda t: np.array(rest) + scale * np.stack([np.sin(2 * np.pi * t), 0 * t, np.cos(3 * t)], axis=1)


@pytest.fixture
def workout(tmp_path):
    folder = tmp_path / "mm-fit" / "w03"
    folder.mkdir(parents=True)
    write_stream(folder / "w03_sw_l_acc.npy", 100, wave(2.0, (0, 0, G)))
    write_stream(folder / "w03_sw_l_gyr.npy", 100, wave(1.0), first_ms=77.0)
    write_stream(folder / "w03_sp_r_acc.npy", 500, wave(2.0 / G, (0, 1, 0)))
    write_stream(folder / "w03_sp_r_gyr.npy", 500, wave(150.0))
    write_stream(folder / "w03_eb_l_acc.npy", 90, wave(1.0, (G, 0, 0)))  # without its gyr: left out
    frames = np.delete(np.arange(N_FRAMES), slice(100, 105))
    pose = np.zeros((3, len(frames), 18))
    pose[:, :, 0] = frames
    pose[:, :, 1:] = np.arange(3)[:, None, None] * 1000 + frames[:, None] + np.arange(17) / 100
    np.save(folder / "w03_pose_3d.npy", pose)
    (folder / "w03_labels.csv").write_text("60,240,10,squats\n300,540,12,jumping_jacks\n")
    return folder


def test_exercises_come_in_on_the_cameras_clock_and_in_si_units(workout):
    exercises = read_mmfit(workout.parent)
    assert [e.recording.activity for e in exercises] == ["squats", "jumping_jacks"]
    first = exercises[0].recording
    assert first.sites == ("left wrist", "right front pocket")
    assert (first.rate, first.n_samples, first.subject) == (RATE_HZ, 300, "person 0")
    time = 2.0 + first.time
    np.testing.assert_allclose(first.acc[:, 0], wave(2.0, (0, 0, G))(time), atol=0.1)
    np.testing.assert_allclose(first.acc[:, 1], G * wave(2.0 / G, (0, 1, 0))(time), atol=0.1)
    np.testing.assert_allclose(first.gyr[:, 0], wave(1.0)(time), atol=0.05)
    np.testing.assert_allclose(first.gyr[:, 1], np.radians(wave(150.0)(time)), atol=0.1)


def test_poses_keep_their_frames_and_gaps(workout):
    pose = read_mmfit(workout.parent)[0].pose
    assert pose.shape == (180, 17, 3)
    np.testing.assert_allclose(pose[0, 4], [60.04, 1060.04, 2060.04])
    assert np.isnan(pose[40:45]).all()
    assert np.isfinite(np.delete(pose, slice(40, 45), axis=0)).all()


def test_what_is_between_the_sets_is_the_eleventh_class(workout):
    (workout / "w03_labels.csv").write_text("200,240,10,squats\n400,440,12,lunges\n")
    exercises = read_mmfit(workout.parent, rests=True)
    assert [e.recording.clip for e in exercises if e.recording.activity == "non_activity"] == [
        "w03 rest 00", "w03 rest 01", "w03 rest 02",
    ]  # fmt: skip
    assert [len(e.pose) for e in exercises] == [40, 40, 200, 160, 160]
    before = exercises[2]
    assert before.recording.n_samples == round(200 / CAMERA_RATE * RATE_HZ)
    np.testing.assert_allclose(before.pose[50, 4], [50.04, 1050.04, 2050.04])
    assert [e.recording.activity for e in read_mmfit(workout.parent)] == ["squats", "lunges"]


def test_rests_are_cut_where_nobody_is_seen_and_after_half_a_minute(workout, monkeypatch):
    monkeypatch.setattr(mmfit, "REST_S", 6.0)
    (workout / "w03_labels.csv").write_text("590,600,1,squats\n")
    pose = np.load(workout / "w03_pose_3d.npy")
    frames = pose[0, :, 0]
    np.save(workout / "w03_pose_3d.npy", pose[:, (frames < 160) | (frames > 200)])
    rests = read_mmfit(workout.parent, rests=True)[1:]
    assert [(e.recording.clip, len(e.pose)) for e in rests] == [
        ("w03 rest 00", 160), ("w03 rest 00", 180), ("w03 rest 00", 180),
    ]  # fmt: skip


def test_rows_that_label_rests_are_rests(workout):
    (workout / "w03_labels.csv").write_text("60,240,10,squats\n240,600,0,non_activity\n")
    assert [e.recording.activity for e in read_mmfit(workout.parent)] == ["squats"]
    rests = read_mmfit(workout.parent, rests=True)[1:]
    assert [(e.recording.clip, len(e.pose)) for e in rests] == [("w03 rest 01", 360)]


def test_a_stream_that_stops_for_a_while_is_lost_there(workout):
    path = workout / "w03_sw_l_acc.npy"
    table = np.load(path)
    seconds = (table[:, 1] - table[0, 1]) / 1000
    np.save(path, table[(seconds < 4) | (seconds > 5)])
    acc = read_mmfit(workout.parent)[0].recording.acc[:, 0]
    lost = np.isnan(acc).any(axis=1)
    assert lost[105:145].all()
    assert not lost[:98].any()
    assert not lost[152:].any()


def test_more_columns_than_the_17_joints_are_allowed(workout):
    path = workout / "w03_pose_3d.npy"
    pose = np.load(path)
    np.save(path, np.concatenate([pose, np.ones((3, pose.shape[1], 15))], axis=2))
    assert read_mmfit(workout.parent)[0].pose.shape == (180, 17, 3)


@pytest.mark.parametrize("unit", ["m/s2", "g"])
def test_the_unit_of_acceleration_is_found_by_gravity(unit):
    rest = np.tile([0, 0, {"m/s2": G, "g": 1.0}[unit]], (100, 1))
    assert guessed_unit(rest, "acc") == unit
    with pytest.raises(ValueError, match=r"neither m/s2 nor g"):
        guessed_unit(100 * rest, "acc")


def test_every_workout_has_its_participant():
    assert mmfit.PARTICIPANTS[0] == 2
    assert mmfit.PARTICIPANTS[20] == 9
    assert set(mmfit.PARTICIPANTS.values()) == set(range(10))


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda w: (w / "w03_labels.csv").unlink(), "holds no workouts"),
        (lambda w: (w / "w03_pose_3d.npy").unlink(), "no workout in .* has its wNN_pose_3d"),
        (lambda w: (w / "w03_labels.csv").write_text(""), "no wNN_labels.csv in .* has a row of an exercise"),
        (lambda w: (w / "w03_labels.csv").write_text("1,2,squats\n"), "line 1: it must be first frame"),
        (lambda w: (w / "w03_labels.csv").write_text("1,20,3,dancing\n"), "no activity 'dancing'"),
        (lambda w: (w / "w03_labels.csv").write_text("20,10,3,squats\n"), "no stretch of time"),
        (lambda w: np.save(w / "w03_sw_l_acc.npy", np.ones((20, 3))), "rows of frame, timestamp"),
        (lambda w: np.save(w / "w03_sw_l_acc.npy", np.ones((20, 5))), "do not advance"),
        (lambda w: (w / "w03_sw_l_acc.npy").write_bytes(b"nothing"), "w03_sw_l_acc.npy is damaged or no npy"),
        (lambda w: np.save(w / "w03_pose_3d.npy", np.ones((3, 5, 4))), r"must have the shape \(3, frames"),
        (lambda w: np.save(w / "w03_pose_3d.npy", np.ones((3, 5, 18))), "do not rise"),
    ],
)
def test_what_is_not_mmfit_is_refused_with_a_sentence(workout, spoil, message):
    spoil(workout)
    with pytest.raises(ValueError, match=message):
        read_mmfit(workout.parent)


def test_pickles_are_not_opened(workout):
    np.save(workout / "w03_sw_l_acc.npy", np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with pytest.raises(ValueError, match="no npy file of numbers"):
        read_mmfit(workout.parent)


def test_labels_are_read_in_order(workout):
    assert read_labels(workout / "w03_labels.csv")[1] == (300, 540, 12, "jumping_jacks")
