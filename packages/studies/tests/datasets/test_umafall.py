# SPDX-License-Identifier: GPL-3.0-or-later
"""UMAFall comes in SI units on one clock; trials without all sites are named, damaged files refused."""

import numpy as np
import pytest

from w2w_studies.datasets.umafall import UMAFALL_ACTIVITIES, UMAFALL_SITES, read_umafall

COLUMNS = np.array(["index", "subject", "kind", "activity", "trial", "age_years"])


def archive(path, rows=(("0", "07", "ADL", "Hopping", "1", "30"),), **changed):
    arrays = {"meta": np.array(rows), "columns": COLUMNS, "acc_lsb_g": 0.0005, "gyr_lsb_dps": 0.0625}
    for row in rows:
        for k, site in enumerate(UMAFALL_SITES):
            for kind in "ag":
                name = f"{int(row[0]):03d}_{site.upper()}_{kind}"
                times = 0.01 * k + np.arange(300) * 0.05
                arrays |= {name: np.full((300, 3), 1000 * (k + 1), np.int16), f"{name}_t": times}
    arrays |= changed
    np.savez(path, **{name: value for name, value in arrays.items() if value is not None})
    return path


def test_four_sites_come_to_one_clock_in_si_units(tmp_path):
    (found,), left_out = read_umafall(archive(tmp_path / "a.npz"))
    assert (found.activity, found.subject, found.rate, found.sites) == ("Hopping", "s07", 20.0, UMAFALL_SITES)
    np.testing.assert_allclose(found.acc[:, 2], 3000 * 0.0005 * 9.80665, rtol=1e-6)
    np.testing.assert_allclose(found.gyr[:, 3], np.radians(4000 * 0.0625), rtol=1e-6)
    assert left_out == ()


def test_falls_are_no_daily_activity_and_a_trial_that_lacks_a_site_is_named(tmp_path):
    named = (("ADL", "Hopping"), ("ADL", "Walking"), ("Fall", "lateralFall"), ("ADL", "Bending"))
    rows = [(str(n), "07", kind, activity, "1", "30") for n, (kind, activity) in enumerate(named)]
    damaged = {"001_WAIST_a": None, "003_ANKLE_g_t": np.zeros(300)}
    found, left_out = read_umafall(archive(tmp_path / "a.npz", rows, **damaged))
    assert [r.activity for r in found] == ["Hopping"]
    assert left_out == (
        "trial 1: it lacks 001_WAIST_a",
        "trial 3: the times of 003_ANKLE_g do not increase",
    )


def test_a_long_silence_is_nan(tmp_path):
    times = np.arange(300) * 0.05
    times[100:] += 1.0
    (found,), _ = read_umafall(archive(tmp_path / "a.npz", **{"000_WRIST_a_t": times}))
    assert 18 <= np.isnan(found.acc[:, 2]).any(axis=1).sum() <= 22
    assert np.isfinite(found.acc[:, 0]).all()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"meta": None}, "it lacks meta"),
        ({"columns": COLUMNS[:3]}, "meta must have the columns index, subject"),
        ({"000_CHEST_a": None}, "no trial of a daily activity can be read"),
        ({"000_CHEST_a": np.array([{}])}, "neither numbers nor text"),
    ],
)
def test_damaged_archives_are_refused_with_a_reason(tmp_path, changed, message):
    with pytest.raises(ValueError, match=message) as raised:
        read_umafall(archive(tmp_path / "a.npz", **changed))
    assert "a.npz is no archive of UMAFall" in str(raised.value)


@pytest.mark.slow
def test_the_archive_at_hand_is_read(shared_data):
    found, left_out = read_umafall(shared_data / "imu" / "umafall" / "umafall.npz")
    assert {r.activity for r in found} == set(UMAFALL_ACTIVITIES)
    assert len(found) > 300
    assert len({r.subject for r in found}) >= 18
    assert "it lacks" in left_out[0]
    level = np.median([np.nanmedian(np.linalg.norm(r.acc, axis=2)) for r in found])
    assert level == pytest.approx(9.8, rel=0.1)
