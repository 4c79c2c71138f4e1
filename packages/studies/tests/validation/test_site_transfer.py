# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors worn with unknown axes and gain are understood once both are found from other people."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.imu.recording import ImuRecording
from w2w.core.windows.windows import WindowSpec
from w2w_studies.validation.site_transfer import (
    by_gravity,
    magnitudes,
    mounting_rotation,
    site_signals,
    try_ways,
    turned,
)

RATE, ACTIVITIES, SPEC = 25.0, ("nod", "shake", "rest"), WindowSpec(stride_s=2.0)
WORN = Rotation.from_euler("xyz", [140, 35, -80], degrees=True)


def recordings(people, seed, rotation=None, gain=1.0):
    """One sensor that swings along its x axis, along its y axis, or rests aslant."""
    rng = np.random.default_rng(seed)
    time, made = np.arange(150) / RATE, []
    for person in people:
        for activity in ACTIVITIES:
            swing = 2.5 * np.sin(2 * np.pi * rng.uniform(0.9, 1.1) * time + rng.uniform(0, 6))
            acc = np.tile([0.0, 0.0, 9.8], (150, 1)) + rng.normal(0, 0.2, (150, 3))
            if activity == "rest":
                acc += [4.0, 0, -1.0]
            else:
                acc[:, "nod shake".split().index(activity)] += swing
            if rotation is not None:
                acc = gain * rotation.apply(acc)
            gyr = np.zeros((150, 1, 3))
            made.append(
                ImuRecording(acc[:, None], gyr, RATE, ("wrist",), activity, person, f"{person} {activity}")
            )
    return made


def signals(*args):
    return site_signals(recordings(*args), ACTIVITIES, SPEC, np.zeros(1, dtype=int), "acc")


def test_the_rotation_is_found_without_pairs():
    (made,), (worn,) = signals(list("abcdef"), 1), signals(list("uvwxyz"), 2, WORN)
    found = mounting_rotation(worn, made) * WORN
    assert np.degrees(found.magnitude()) < 6


def test_only_a_rotation_tells_what_only_axes_tell():
    made, worn = signals(list("abcdef"), 1), signals(list("uvwxyz"), 2, WORN, 0.75)
    found = {way.way: way for way in try_ways(worn, made, len(ACTIVITIES))}
    assert found["gain, one rotation a site"].simulated[0] > 0.95
    assert found["axes and gain as they are"].simulated[0] < 0.7
    assert found["gain, along and across gravity"].simulated[0] < 0.8  # nod and shake look the same
    assert found["axes and gain as they are"].real[0] > 0.95


@pytest.mark.parametrize("view", [magnitudes, by_gravity])
def test_invariant_signals_do_not_change_with_the_axes(view):
    x = np.random.default_rng(0).normal(size=(5, 50, 6)).astype(np.float32) + [0, 3, 0, 0, 0, 0]
    np.testing.assert_allclose(view(turned(x, WORN)), view(x), atol=1e-5)


def test_a_site_gathers_its_sensors():
    both = [ImuRecording(np.repeat(r.acc, 2, 1), np.repeat(r.gyr, 2, 1) + 1, RATE, ("a", "b"), r.activity,
                         r.subject, r.clip) for r in recordings("ab", 0)]  # fmt: skip
    (found,) = site_signals(both, ACTIVITIES[:2], SPEC, np.array([0, 0]), "acc")
    assert len(found.signals) == len(found.label) == len(found.person) == 2 * 2 * 2 * 3
    assert not found.signals[..., 3:].any()
    assert set(found.label.tolist()) == {0, 1}
