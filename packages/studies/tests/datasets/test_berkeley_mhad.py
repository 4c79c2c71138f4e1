# SPDX-License-Identifier: GPL-3.0-or-later
"""Berkeley MHAD's accelerometers: on one clock, in m/s2, and refused with a reason where they are damaged."""

import numpy as np
import pytest

from w2w_studies.datasets.berkeley_mhad import MHAD_ACTIONS, MHAD_SITES, read_berkeley_mhad

G = 9.80665


def table(seconds=3.0, start=0.0, slope=0.0):
    """Readings that rise by `slope` g a second along x and rest at 1 g along z, unevenly spaced."""
    rng = np.random.default_rng(0)
    t = start + np.cumsum(rng.uniform(0.028, 0.036, int(seconds / 0.032)))
    return np.column_stack([t, slope * t, np.zeros_like(t), np.ones_like(t)])


def archive(path, **changed):
    arrays = {f"s03_a08_r02_h0{k}": table(start=0.01 * k) for k in range(1, 7)} | changed
    np.savez(path, **{name: value for name, value in arrays.items() if value is not None})
    return path


def test_six_sites_come_to_one_clock_in_si_units(tmp_path):
    (found,) = read_berkeley_mhad(archive(tmp_path / "acc.npz", s03_a08_r02_h02=table(slope=0.5)))
    assert (found.activity, found.subject, found.clip) == ("throw", "s03", "s03_a08_r02")
    assert found.sites == MHAD_SITES
    assert found.rate == 30.0
    np.testing.assert_allclose(np.diff(found.acc[:, 1, 0]), 0.5 * G / 30, rtol=1e-3)
    np.testing.assert_allclose(found.acc[:, :, 2], G, rtol=1e-6)
    assert not found.gyr.any()


def test_what_was_lost_is_nan(tmp_path):
    broken = table()
    broken = np.delete(broken, slice(20, 40), axis=0)
    path = archive(tmp_path / "acc.npz", s03_a08_r02_h05=broken, s03_a08_r02_h06=None)
    (found,) = read_berkeley_mhad(path)
    lost = np.isnan(found.acc).any(axis=2)
    assert 15 <= lost[:, 4].sum() <= 21
    assert lost[:, 5].all()
    assert not lost[:, :4].any()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"s03_a12_r01_h01": table()}, "s03_a12_r01_h01 is of none of the actions a01 to a11"),
        ({"s03_a08_r01_h07": table()}, "sensors h01 to h06"),
        ({"s03_a08_r02_h01": table()[:, :3]}, r"s03_a08_r02_h01 must be \(T, 4\): t, x, y, z, not"),
        ({"s03_a08_r02_h01": table()[:1]}, r"must be \(T, 4\)"),
        ({"s03_a08_r02_h01": np.array([["a", "b", "c", "d"]] * 9)}, r"must be \(T, 4\)"),
        (
            {"s03_a08_r02_h01": table() * [1, 1, np.nan, 1]},
            "s03_a08_r02_h01 holds values that are not finite",
        ),
        ({"s03_a08_r02_h01": table() * [1, 0, 0, 30]}, "s03_a08_r02_h01 holds readings beyond 2 g alone"),
        ({"s03_a08_r02_h01": table()[::-1]}, "the times of s03_a08_r02_h01 do not increase"),
        (
            {"s03_a08_r02_h01": table(start=60)},
            "trial s03_a08_r02 is of no use, its sensors share less than 0.5 s",
        ),
        ({"s03_a08_r02_h01": np.array([{}] * 4)}, "neither numbers nor text"),
    ],
)
def test_damaged_arrays_are_named(tmp_path, changed, message):
    with pytest.raises(ValueError, match=message) as raised:
        read_berkeley_mhad(archive(tmp_path / "acc.npz", **changed))
    assert "acc.npz" in str(raised.value)


def test_other_files_are_refused(tmp_path):
    (tmp_path / "text.npz").write_text("no zip")
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    with pytest.raises(ValueError, match=r"text\.npz is no archive of Berkeley MHAD's accelerometers"):
        read_berkeley_mhad(tmp_path / "text.npz")
    with pytest.raises(ValueError, match="it holds no array named like s01_a01_r01_h01"):
        read_berkeley_mhad(tmp_path / "other.npz")
    with pytest.raises(OSError, match="absent"):
        read_berkeley_mhad(tmp_path / "absent.npz")


def test_the_archive_at_hand_shows_what_its_actions_are_called(shared_data):
    """Waving the right hand and throwing move the right wrist most, jumping both ankles alike."""
    found = read_berkeley_mhad(shared_data / "imu" / "berkeley_mhad" / "acc.npz")
    assert {r.activity for r in found} == set(MHAD_ACTIONS)
    assert len({r.subject for r in found}) == 12
    swing = {
        name: np.median(
            [np.nanstd(np.linalg.norm(r.acc, axis=2), axis=0) for r in found if r.activity == name], 0
        )
        for name in ("wave right hand", "throw", "jump in place")
    }
    for name in ("wave right hand", "throw"):
        assert swing[name].argmax() == MHAD_SITES.index("right wrist")
    assert swing["jump in place"][4] == pytest.approx(swing["jump in place"][5], rel=0.3)
    assert max(np.nanmax(np.abs(r.acc)) for r in found) <= 2 * G + 1e-3
    level = np.median([np.nanmedian(np.linalg.norm(r.acc, axis=2), axis=0) for r in found], axis=0)
    assert ((level > 0.7 * G) & (level < 1.1 * G)).all()  # the sensors are not calibrated


def test_a_sample_that_no_sensor_can_read_is_bridged(tmp_path):
    broken = table()
    broken[40, 2] = 47.2
    (found,) = read_berkeley_mhad(archive(tmp_path / "acc.npz", s03_a08_r02_h01=broken))
    np.testing.assert_allclose(found.acc[:, 0, 1], 0, atol=1e-6)
    assert np.isfinite(found.acc).all()
