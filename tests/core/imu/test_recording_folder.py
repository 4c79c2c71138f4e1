# SPDX-License-Identifier: GPL-3.0-or-later
"""Three taps on a sensor at rest mark an activity's start and end; no activity makes them by itself."""

import numpy as np
import pytest

from w2w.core.imu import recording_folder
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.recording_folder import triple_taps
from w2w.core.imu.recordings import Recordings

from ...phone_exports import G, table

ACTIVITIES = ("walking", "sitting down", "sitting")


def worn(kinds, rate=100, n_taps=3, seed=0, rest=3.0, strength=8.0):
    """Norm-like specific force of stretches of 12 s, at rest before and after, with taps in the rests."""
    rng, pieces = np.random.default_rng(seed), []
    for number in range(len(kinds) + 1):
        still = np.zeros(round(2 * rest * rate))
        for tap in range(n_taps):
            at = round((rest + 0.35 * tap + rng.uniform(-0.05, 0.05)) * rate)
            still[at : at + 6] += (
                strength * np.exp(-np.arange(6) * 40 / rate) * np.cos(np.arange(6) * 200 / rate)
            )
        pieces.append(still)
        if number < len(kinds):
            t = np.arange(12 * rate) / rate
            pieces.append(kinds[number] * np.sin(2 * np.pi * 2 * t) ** 5)
    up = np.concatenate(pieces)
    acc = np.stack([np.zeros_like(up), np.zeros_like(up), G + up], axis=1)
    return acc + rng.normal(scale=0.1, size=acc.shape)


def written(path, acc, rate=100):
    return table(path, ["time", "gFx", "gFy", "gFz"], np.arange(len(acc)) / rate, acc / G)


@pytest.mark.parametrize("rate", [50, 100, 208])
@pytest.mark.parametrize("strength", [5.0, 40.0])
def test_three_taps_are_found_and_two_or_four_are_not(rate, strength):
    for n_taps, found in ((3, 3), (2, 0), (4, 0), (0, 0)):
        acc = worn([5, 9], rate, n_taps, strength=strength)[:, None]
        marks = triple_taps(ImuRecording(acc, np.zeros_like(acc), rate))
        assert len(marks) == found
        assert np.allclose(marks, [(2.5 + 18 * n, 4.2 + 18 * n) for n in range(found)], atol=0.15)


def test_what_lies_between_taps_is_each_activity_in_the_order_of_the_path(tmp_path):
    written(tmp_path / "Ada" / "walking, sitting down.csv", worn([5, 0]))
    written(tmp_path / "Ben" / "sitting.csv", worn([0]))
    written(tmp_path / "Cy" / "walking_1.csv", worn([5], n_taps=0))
    acc = np.concatenate([worn([4]), worn([6])])
    written(tmp_path / "Dee" / "walking walking.csv", acc)
    found = Recordings.read(tmp_path, place="left wrist", activities=ACTIVITIES)
    told = [(one.subject, one.activity, round(one.time[-1])) for one in found]
    assert told == [
        ("Ada", "walking", 16), ("Ada", "sitting down", 16), ("Ben", "sitting", 16), ("Cy", "walking", 24),
        ("Dee", "walking", 16), ("Dee", "walking", 16),
    ]  # fmt: skip
    said = dict(found.skipped)
    assert said.keys() == {"Ada/walking, sitting down.csv", "Ben/sitting.csv", "Dee/walking walking.csv"}
    assert said["Ben/sitting.csv"].startswith("all but 4.")
    assert said["Ben/sitting.csv"].endswith("s sitting, by its triple taps")
    spread = [float(np.ptp(one.acc[:, 0, 2])) for one in found]
    assert min(spread[0], spread[4], spread[5]) > 7
    assert max(spread[1], spread[2]) < 1.5


def test_taps_that_do_not_fit_the_path_are_said(tmp_path):
    written(tmp_path / "Ada" / "walking.csv", worn([5, 0]))
    written(tmp_path / "Ben" / "walking sitting.csv", worn([5], n_taps=0))
    written(tmp_path / "Cy" / "walking.csv", worn([5]))
    (tmp_path / "Cy" / "taps.csv").write_text("a,b\n1,2\n")
    found = Recordings.read(tmp_path, place="left wrist", activities=ACTIVITIES)
    said = dict(found.skipped)
    assert "it has 3 triple taps: tap at start and end of all 1" in said["Ada/walking.csv"]
    assert "its path names walking and sitting, and no triple taps" in said["Ben/walking sitting.csv"]
    assert [one.subject for one in found] == ["Cy"]


def test_labels_go_before_taps(tmp_path):
    written(tmp_path / "a.csv", worn([5]))
    (tmp_path / "labels.csv").write_text("file,activity,start,end\na.csv,walking,2,20\n")
    (one,) = Recordings.read(tmp_path, place="left wrist")
    assert one.time[-1] == pytest.approx(18, abs=0.1)


def test_people_who_clap_knock_and_jump_make_none(shared_data, monkeypatch):
    monkeypatch.setattr(recording_folder, "SLOWEST_HZ", 0.0)
    tried = []
    with np.load(shared_data / "imu" / "utd_mhad" / "utd_mhad_subjects_1_4.npz") as held:
        tried += [(held[name][:, :3], 50.0) for name in held.files if name.endswith("_imu")]
    with np.load(shared_data / "imu" / "berkeley_mhad" / "acc.npz") as held:
        names = [name for name in held.files if name.startswith("s01") and len(held[name]) > 60]
        tried += [(held[name][:, 1:4], 31.0) for name in names]
    for acc, rate in tried:
        force = acc[:, None].astype(float) * G
        assert not triple_taps(ImuRecording(force, np.zeros_like(force), rate))
    assert sum(len(acc) / rate for acc, rate in tried) > 3000
