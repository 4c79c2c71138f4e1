# SPDX-License-Identifier: GPL-3.0-or-later
"""Each candidate changes how hard sensors are moved, and nothing else."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from w2w.core.imu.recording import ImuRecording
from w2w.core.windows.features import feature_names
from w2w.core.windows.windows import WindowSpec
from w2w.studies.comparisons.unpaired import Side
from w2w.studies.experiments import vigour_views, why_rows, why_vigour
from w2w.studies.validation.site_windows import SiteWindows, site_windows

GRAVITY = np.array([0.0, 0.0, 9.81])


def drawn(seed=0, hard=1.0):
    """Windows of two sensors about different postures."""
    rng = np.random.default_rng(seed)
    moved = rng.normal(size=(3, 2, 100, 6)).cumsum(axis=2)
    moved -= moved.mean(axis=2, keepdims=True)
    signals = hard * moved
    signals[..., :3] += rng.normal(size=(3, 2, 1, 3)) * 5
    return signals


@pytest.mark.parametrize("view", [vigour_views.unit_windows, vigour_views.compressed])
def test_posture_and_directions_of_movement_stay(view):
    signals = drawn()
    out = view(signals)
    still = signals[..., :3].mean(axis=2, keepdims=True)
    for before, after in ((signals[..., :3] - still, out[..., :3] - still), (signals[..., 3:], out[..., 3:])):
        np.testing.assert_allclose(
            np.cross(before, after), 0, atol=1e-9 * np.abs(before).max() * np.abs(after).max()
        )
        assert (np.sum(before * after, axis=-1) > 0).all()


@given(st.floats(0.8, 20))
def test_windows_equally_hard_are_the_same_however_hard_they_were(hard):
    once, harder = (vigour_views.unit_windows(drawn(hard=size)) for size in (1.0, hard))
    np.testing.assert_allclose(harder, once, rtol=1e-9, atol=1e-9)


def test_noise_of_a_still_sensor_is_not_blown_up():
    still = np.zeros((1, 1, 100, 6))
    still[..., :3] = GRAVITY
    still += np.random.default_rng(0).normal(0, 0.01, still.shape)
    out = vigour_views.unit_windows(still)
    assert out[..., :3].std(axis=2).max() < 0.3
    np.testing.assert_array_equal(vigour_views.unit_windows(still * 0), 0)


def test_compressing_keeps_the_order_and_brings_sizes_together():
    sizes = np.array([0.0, 0.1, 1.0, 10.0, 100.0])
    signals = np.zeros((1, 1, 10, 6))
    signals[0, 0, :5, 3], signals[0, 0, 5:, 3] = sizes, -sizes
    out = vigour_views.compressed(signals)[0, 0, :5, 3]
    assert (np.diff(out) > 0).all()
    np.testing.assert_allclose(out, 0.25 * np.log1p(sizes / 0.25), rtol=1e-9, atol=1e-9)


def test_directions_have_one_length():
    out = vigour_views.directions(drawn())
    np.testing.assert_allclose(np.linalg.norm(out[..., :3], axis=-1), 9.80665, rtol=1e-4)
    np.testing.assert_array_equal(np.sign(out), np.sign(drawn()))


def clip(hard, activity="walk", name="clip", seed=0, sensors=2):
    rng = np.random.default_rng(seed)
    acc = GRAVITY + hard * rng.normal(size=(200, sensors, 3))
    gyr = hard * rng.normal(size=(200, sensors, 3))
    sites = tuple(f"site {number}" for number in range(sensors))
    return ImuRecording(acc, gyr, 50.0, sites, activity, "p", name)


def test_clips_are_brought_to_one_hardness_and_sensors_keep_their_ratio():
    quiet, loud = vigour_views.unit_clips([clip(np.array([[1.0], [3.0]]), seed=s) for s in (0, 1)])
    for one in (quiet, loud):
        sizes = vigour_views.hardness(one)
        assert np.sqrt(np.square(sizes).mean()) == pytest.approx(4.0, rel=1e-3)
        assert sizes[1] / sizes[0] == pytest.approx(3, rel=0.1)


def test_chance_is_drawn_once_a_clip_and_the_same_again():
    clips = [clip(1.0, name=str(n), seed=n) for n in range(4)]
    first, again = (vigour_views.varied_clips(clips, seed=3) for _ in range(2))
    for before, one, other in zip(clips, first, again, strict=True):
        np.testing.assert_array_equal(one.acc, other.acc)
        ratio = vigour_views.hardness(one) / vigour_views.hardness(before)
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-3)
        np.testing.assert_allclose(one.gyr / before.gyr, ratio[0], rtol=1e-3)


def test_simulated_clips_are_done_as_hard_as_people_do_them_site_by_site():
    worn = Side([clip(np.array([[1.0], [2.0]]), seed=s, name=f"w{s}") for s in range(3)], None, {})
    made = Side([clip(np.array([[2.0], [2.0], [2.0]]), seed=s, sensors=3) for s in range(3)], None, {})
    site_of = np.array([0, 1, 1])
    out = vigour_views.as_hard_as_people(made, worn, site_of)
    found = np.median([vigour_views.hardness(one) for one in out], axis=0)
    wanted = np.median([vigour_views.hardness(one) for one in worn.recordings], axis=0)[site_of]
    np.testing.assert_allclose(found, wanted, rtol=0.05)
    other = vigour_views.as_hard_as_people(made, Side([clip(1.0, "jump")], None, {}), site_of)
    np.testing.assert_allclose(other[0].acc, made.recordings[0].acc, rtol=1e-5)  # nobody wore it walking


def test_features_of_lengths_go_and_no_others():
    windows = site_windows([clip(1.0)], WindowSpec())
    names = feature_names(100, 50.0)
    shorter = vigour_views.without_lengths(windows, vigour_views.Sampled(100, 50.0))
    kept = [number for number, name in enumerate(names) if "|" not in name]
    assert 0 < len(kept) < len(names)
    np.testing.assert_array_equal(shorter.features, windows.features[..., kept])
    assert names[kept[-1]] == "gyr y * gyr z"


def test_sources_get_one_mean_whatever_they_show_most_of():
    features = np.array([[[1.0]], [[1.0]], [[3.0]], [[11.0]], [[13.0]], [[13.0]]], dtype=np.float32)
    activity = np.array(["a", "a", "b", "a", "b", "b"])
    labels = np.array(list("uvwxyz"))
    windows = SiteWindows(features, activity, labels, labels, np.ones(6, bool), {})
    out = vigour_views.same_mean_by_source(windows, np.array(["s"] * 3 + ["t"] * 3)).features[:, 0, 0]
    np.testing.assert_allclose(out, [6, 6, 8, 6, 8, 8])


def test_the_choice_is_by_rho_then_regret_and_none_if_none_is_better():
    def rows(rho, regret):
        return [
            why_rows.Row(one.name, 0.5, why_rows.NONE, (r, r, r), (g, g, g), why_rows.NONE)
            for one, r, g in zip(why_vigour.CANDIDATES, rho, regret, strict=True)
        ]

    n = len(why_vigour.CANDIDATES)
    flat = rows([0.5] * n, [0.1] * n)
    assert why_vigour.chosen([flat, flat]) == why_vigour.AS_FIXED
    better = rows([0.5, 0.6, 0.6, *[0.4] * (n - 3)], [0.1, 0.2, 0.1, *[0.0] * (n - 3)])
    assert why_vigour.chosen([better, flat]) == why_vigour.CANDIDATES[2].name
    worse = rows([0.5, 0.3, *[0.2] * (n - 2)], [0.1] * n)
    assert why_vigour.chosen([flat, worse]) == why_vigour.AS_FIXED


def test_what_was_chosen_is_a_candidate_and_none_looks_at_the_worn_sensors():
    names = [one.name for one in why_vigour.CANDIDATES]
    assert why_vigour.CHOSEN in names
    assert len(set(names)) == len(names)
    assert names[0] == why_vigour.AS_FIXED
    assert why_vigour.ORACLE not in names


@pytest.mark.slow
def test_every_candidate_is_scored_on_real_files(shared_data, some_mhad):
    few = some_mhad(7, ("a03", "a05"), ("r01",))
    library = shared_data / "bvh" / "bandai_namco"
    rows = why_vigour.candidates("mhad", few, [library], "all actions")
    seen = [*(one.name for one in why_vigour.CANDIDATES), why_vigour.ORACLE]
    assert [row.step for row in rows] == [*seen, *(f"{name}, magnitudes" for name in seen)]
    by_name = {row.step: row for row in rows}
    fixed = by_name[why_vigour.AS_FIXED]
    assert fixed.against == (0, 0, 0)
    assert by_name["sources of one mean"].f1 == pytest.approx(fixed.f1, abs=0.02)  # there is one source
    assert by_name[why_vigour.CHOSEN].f1 != fixed.f1
