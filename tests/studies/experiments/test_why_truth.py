# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands in for worn sensors is compared with what is worn, and nothing else is changed on the way."""

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.studies.experiments import why_rows, why_truth, why_views
from w2w.studies.validation.site_scores import SiteScores


def scored(halves, f1):
    """Scores of 3 sites and 2 activities with given halves of the people."""
    samples = np.broadcast_to(f1, (5, *np.shape(f1))).copy()
    return SiteScores(("a", "b"), f1, samples, halves, "people", 4, 8, 16, "ridge", "", {})


def test_the_other_half_of_the_people_judges():
    rising, falling = (np.array([[0.1, 0.2], [0.4, 0.5], [0.7, 0.9]])[::way] for way in (1, -1))
    torn = scored(np.stack([np.stack([rising] * 2), np.stack([falling] * 2)]), rising)
    of_mean, by_activity, regret = why_rows.agreement(torn, torn, people=True)
    np.testing.assert_allclose(by_activity[0], -1)  # one half is never judged by itself
    np.testing.assert_allclose(of_mean[0], -1)
    np.testing.assert_allclose(regret[0], 0.65)
    alike = why_rows.agreement(torn, scored(torn.halves, rising), people=False)
    np.testing.assert_allclose(alike[1][0], [1, 1, -1, -1])
    np.testing.assert_allclose(alike[2][0], [0, 0, 0.65, 0.65])


def swinging(hertz, noise=0.0):
    time = np.arange(200) / 50
    acc = np.stack([np.sin(2 * np.pi * hertz * time), np.zeros(200), np.full(200, 9.81)], axis=1)[:, None]
    acc = acc + noise * np.random.default_rng(0).normal(size=acc.shape)
    return ImuRecording(acc, np.zeros_like(acc), 50.0, ("wrist",), "wave", "p", "clip")


def test_tempo_is_how_fast_the_force_swings_whatever_is_lost():
    slow, fast = (why_views.tempo([swinging(hertz)])["wave"] for hertz in (0.9, 1.8))
    assert fast / slow == pytest.approx(2, rel=0.05)
    holed = swinging(1.8)
    holed.acc[60:63] = np.nan
    assert why_views.tempo([holed])["wave"] == pytest.approx(fast, rel=0.05)


def test_the_band_leaves_slow_movement_and_what_is_lost():
    noisy = swinging(1.0, noise=2.0)
    noisy.acc[60:63] = np.nan
    below = why_views.below(noisy, 3.0)
    np.testing.assert_array_equal(np.isnan(below.acc), np.isnan(noisy.acc))
    clear = swinging(1.0).acc
    before, after = (np.nanstd(one.acc - clear) for one in (noisy, below))
    assert after < before / 2
    assert below.clip == noisy.clip


def test_posture_is_taken_from_each_window_alone():
    windows = np.random.default_rng(0).normal(size=(3, 2, 50, 6)) + 5
    out = why_views.without_posture(windows)
    np.testing.assert_allclose(out[..., :3].mean(axis=2), 0, atol=1e-12)
    np.testing.assert_array_equal(out[..., 3:], windows[..., 3:])


def test_steps_replace_one_thing_at_a_time():
    for step in why_truth.STEPS:
        assert sum(map(bool, (step.view, step.made))) <= 1
        assert step.view in why_views.VIEWS
    assert len({step._replace(name="") for step in why_truth.STEPS}) == len(why_truth.STEPS)


@pytest.mark.slow
def test_every_step_is_climbed_on_real_files(shared_data, some_mhad, tmp_path):
    few = some_mhad(7, ("a03", "a05"), ("r01",))
    library = shared_data / "bvh" / "bandai_namco"
    rows = why_truth.ladder("mhad", few, [library], "all actions")
    assert [row.step for row in rows] == [step.name for step in why_truth.STEPS]
    by_name = {row.step: row for row in rows}
    fixed = by_name["simulated, as fixed"]
    assert fixed.against == (0, 0, 0)
    assert by_name["simulated, sources apart"].f1 == fixed.f1  # there is one source
    assert by_name["simulated, worn loosely"].f1 != fixed.f1
    assert all(-1 <= row.by_activity[0] <= 1 and 0 <= row.regret[0] <= 1 for row in rows)
    why_rows.tell(tmp_path / "why_mhad_all_actions.csv", "mhad, all actions", rows)
    why_truth.figure(tmp_path)
    assert (tmp_path / "why.png").read_bytes().startswith(b"\x89PNG")
    lines = (tmp_path / "why_mhad_all_actions.csv").read_text().splitlines()
    assert len(lines) == 1 + len(why_truth.STEPS)
