# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of phone apps: read as they were recorded, or refused with what to do; never misread."""

import numpy as np
import pytest

from w2w.core.imu.phone_files import is_phone_folder, read_phone

from ...phone_exports import ACC, GYR, RATE, SECONDS, T, doubtful, right, table

RIGHT, DOUBTFUL = right(), doubtful()


def test_there_are_enough_variants():
    assert len(RIGHT) + len(DOUBTFUL) >= 100


@pytest.mark.parametrize("name", RIGHT)
def test_what_an_app_wrote_is_read_as_it_was_recorded(tmp_path, name):
    write, sign, turns = RIGHT[name]
    found = read_phone(write(tmp_path / "one"))
    assert found.rate == RATE
    assert abs(found.n_samples / RATE - SECONDS) < 0.3
    at = slice(20, 400)
    best = min(
        np.abs(found.acc[at, 0] - sign * ACC[at.start + lag : at.stop + lag]).max() for lag in range(-6, 7)
    )
    assert best < 0.02
    if turns:
        least = min(
            np.abs(found.gyr[at, 0] - GYR[at.start + lag : at.stop + lag]).max() for lag in range(-6, 7)
        )
        assert least < 0.005
    else:
        assert not found.gyr.any()


@pytest.mark.parametrize("name", DOUBTFUL)
def test_what_is_in_doubt_is_refused_with_what_to_do(tmp_path, name):
    write, why = DOUBTFUL[name]
    with pytest.raises(ValueError, match=why):
        read_phone(write(tmp_path / "one"))


def test_gaps_are_lost_and_jitter_and_repeated_stamps_are_not(tmp_path):
    rng = np.random.default_rng(2)
    jittered = T + rng.uniform(-0.004, 0.004, len(T))
    jittered[100] = jittered[101]
    kept = (T < 5) | (T > 6)
    names = ["Time (s)", *(f"Acceleration {a} (m/s^2)" for a in "xyz")]
    found = read_phone(table(tmp_path / "a.csv", names, jittered[kept], ACC[kept]))
    assert found.rate == RATE
    lost = np.isnan(found.acc[:, 0, 0])
    assert 0.9 < lost.sum() / RATE < 1.1
    np.testing.assert_allclose(found.acc[30:200, 0], ACC[30:200], atol=0.4)


def test_a_folder_of_sensors_is_one_recording_and_others_are_not(tmp_path):
    RIGHT["phyphox, two files"][0](tmp_path / "phone")
    table(tmp_path / "mine" / "left wrist.csv", ["a"], T)
    assert is_phone_folder(tmp_path / "phone")
    assert not is_phone_folder(tmp_path / "mine")
