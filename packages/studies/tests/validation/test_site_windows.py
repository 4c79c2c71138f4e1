# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings become windows of the signals that are used; what gives none is named."""

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.core.windows.windows import WindowSpec
from w2w_studies.validation.site_windows import site_windows

RATE, SPEC = 25.0, WindowSpec(length_s=2.0, stride_s=1.0)


def recordings(sites, seed, clips):
    """Clips of noise."""
    rng = np.random.default_rng(seed)
    shape = (100, len(sites), 3)
    return [
        ImuRecording(
            rng.normal(size=shape), rng.normal(size=shape), RATE, sites, "slow", "p", f"clip {number}"
        )
        for number in range(clips)
    ]


def test_one_kind_of_signal_alone_can_be_compared():
    made = recordings(("clear",), 1, clips=3)
    windows = site_windows(made, SPEC, use="gyr")
    moved = [ImuRecording(r.acc + 50, r.gyr, RATE, r.sites, r.activity, r.subject, r.clip) for r in made]
    np.testing.assert_array_equal(windows.features, site_windows(moved, SPEC, use="gyr").features)
    assert not np.array_equal(windows.features, site_windows(made, SPEC).features)
    turned = [ImuRecording(r.acc, r.gyr + 5, RATE, r.sites, r.activity, r.subject, r.clip) for r in made]
    raw = site_windows(made, SPEC, use="gyr", inputs="windows").features
    assert raw.shape == (*windows.features.shape[:2], SPEC.samples(made[0].rate), 6)
    assert not raw[..., :3].any()
    assert raw[..., 3:].any()
    without = site_windows(made, SPEC, use="acc").features
    np.testing.assert_array_equal(without, site_windows(turned, SPEC, use="acc").features)


def test_clips_too_short_are_named_and_different_sites_refused():
    made = recordings(("clear",), 1, clips=2)
    short = ImuRecording(made[0].acc[:5], made[0].gyr[:5], RATE, ("clear",), "slow", "p", "short one")
    assert set(site_windows([*made, short], SPEC).skipped) == {"short one"}
    with pytest.raises(ValueError, match="no clip gives a window"):
        site_windows([short], SPEC)
    with pytest.raises(ValueError, match="must share their sites"):
        site_windows([made[0], recordings(("fair",), 1, clips=1)[0]], SPEC)


def test_windows_are_looked_at_in_another_way():
    made = recordings(("clear",), 1, clips=2)
    doubled = [ImuRecording(2 * r.acc, r.gyr, RATE, r.sites, r.activity, r.subject, r.clip) for r in made]

    def view(windows):
        return windows * np.repeat([2, 1], 3).astype(np.float32)

    seen = site_windows(made, SPEC, view=view)
    np.testing.assert_allclose(seen.features, site_windows(doubled, SPEC).features, rtol=1e-5, atol=1e-5)
    assert not np.allclose(seen.features, site_windows(made, SPEC).features)


def test_some_windows_keep_what_belongs_to_them():
    windows = site_windows(recordings(("clear",), 1, clips=2), SPEC)
    second = windows.some(windows.clip == "clip 1")
    assert set(second.clip) == {"clip 1"}
    assert len(second.features) == len(second.is_test) == len(second.clip) < len(windows.clip)
    np.testing.assert_array_equal(second.features, windows.features[windows.clip == "clip 1"])
