# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips in a stream: standing between them, a way there that a body could go, and windows where they fall."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import STANDARD_GRAVITY, Synthesis
from w2w.core.patches.naming import place
from w2w.core.patches.own_placements import patches_at
from w2w.core.windows.stream import BLEND_S, NO_CLIP, STANDING_S, _way, standing_reading, stream_windows

RATE = 50.0
STANDING = np.array([[0.0, 0.0, 9.8, 0.0, 0.0, 0.0]])


def clip_of(seconds, value):
    """A clip in which every channel reads one value, which no standing does."""
    signals = np.full((round(seconds * RATE), 1, 3), value)
    return ImuRecording(signals, signals, RATE)


def streamed(seconds, length_s=2.0, draw=(0, 0, 0)):
    clips = [clip_of(length, 20.0 + number) for number, length in enumerate(seconds)]
    return stream_windows(clips, STANDING, SensorModel.ideal(), length_s, draw)


def test_a_window_is_of_the_clip_that_it_holds_most_of_if_that_is_half_of_clip_or_window():
    seconds = [0.6, 1.0, 3.0, 7.0]
    signals, owner = streamed(seconds)
    held = np.array([(signals[:, 0, :, 3] == 20.0 + number).sum(axis=1) for number in range(4)])
    needed = np.minimum(np.array(seconds) * RATE, 100) / 2
    enough = np.where(held >= needed[:, None], held, 0)
    assert (owner == np.where(enough.any(axis=0), enough.argmax(axis=0), NO_CLIP)).all()
    assert set(owner) == {NO_CLIP, 0, 1, 2, 3}


def test_people_stand_between_clips_for_a_drawn_time():
    _, owner = streamed([1.0] * 40, length_s=0.04)  # windows of two samples, one at each sample
    there = np.concatenate([[0], owner != NO_CLIP, [0]])
    first, last = np.flatnonzero(np.diff(there) == 1), np.flatnonzero(np.diff(there) == -1)
    pauses = (first[1:] - last[:-1]) / RATE
    assert len(first) == 40
    assert STANDING_S[0] - 0.05 <= pauses.min() < 1.3
    assert 2.2 < pauses.max() <= STANDING_S[1]


def test_order_and_pauses_are_drawn():
    one, again, other = (streamed([1.0, 2.0, 3.0], draw=(0, order, 0)) for order in (0, 0, 1))
    assert (one.signals == again.signals).all()
    assert one.signals.shape != other.signals.shape or (one.signals != other.signals).any()


def test_a_stream_shorter_than_a_window_ends_in_standing():
    signals, owner = streamed([1.0], length_s=20.0)
    assert signals.shape[2] == 20 * RATE
    assert owner.tolist() == [0]


def test_on_its_way_to_stand_a_sensor_reads_the_turn_of_gravity():
    start = np.array([[9.8, 0.0, 0.0, 0.0, 0.0, 0.0]])
    way = _way(start, STANDING, round(BLEND_S * RATE) * 20, RATE * 20)[:, 0]  # finely, to add it up
    assert np.linalg.norm(way[:, :3], axis=1) == pytest.approx(9.8)
    turned = Rotation.identity()
    for rate in way[:, 3:]:
        turned = turned * Rotation.from_rotvec(rate / (RATE * 20))
    assert turned.inv().apply(start[0, :3]) == pytest.approx(STANDING[0, :3], abs=0.05)


def test_who_stands_feels_gravity_along_hanging_arms(bundled_body):
    places = patches_at(bundled_body, {name: place(name, bundled_body) for name in ("left wrist", "chest")})
    readings = standing_reading(bundled_body, places, Synthesis())
    assert np.linalg.norm(readings[:, :3], axis=1) == pytest.approx(STANDARD_GRAVITY, abs=1e-3)
    assert readings[:, 3:] == pytest.approx(0, abs=1e-6)
    assert abs(readings[:, 2]).max() < 0.6 * STANDARD_GRAVITY  # on the outside of arm and chest: no way up
