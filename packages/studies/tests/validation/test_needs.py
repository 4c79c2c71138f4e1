# SPDX-License-Identifier: GPL-3.0-or-later
"""Worn and simulated sensors are held against each other by the steps that were fixed in advance."""

import numpy as np
import pytest

from w2w.core.imu.presets import PRESETS
from w2w.core.imu.recording import ImuRecording
from w2w.core.study.variants import ALONE, BITS, FORCE_RANGE, RATE, variants
from w2w.core.windows.windows import WindowSpec
from w2w_studies.comparisons.needs import write_needs
from w2w_studies.validation.needs import VALUES, Side, curves, simulated, verdicts, worn
from w2w_studies.validation.site_windows import site_windows

pytestmark = pytest.mark.slow

HZ, PART, SPEC = 30.0, PRESETS["bmi270"], WindowSpec()


def side(usual, rate, seed):
    """Three people who swing two sensors at 1 or 6 Hz; the second sensor sees nothing of it."""
    rng, time, made = np.random.default_rng(seed), np.arange(int(4 * rate)) / rate, []
    for person in range(3):
        for activity, hertz in (("slow", 1.0), ("fast", 6.0)):
            for clip in range(3):
                acc = 0.5 * rng.normal(size=(len(time), 2, 3)) + [0, 0, 9.8]
                acc[:, 0, 0] += 4 * np.sin(2 * np.pi * hertz * time + rng.uniform(0, 6))
                gyr = 0.05 * rng.normal(size=acc.shape)
                labels = (("wrist", "box"), activity, f"person {person}", f"{person} {activity} {clip}")
                made.append(ImuRecording(acc, gyr, rate).labelled(*labels))
    return Side(made, usual, None)


@pytest.fixture(scope="module")
def found():
    sides = (side(worn(PART, HZ, SPEC), HZ, 1), side(simulated(PART, HZ, SPEC), 200.0, 2))
    return curves("made", ("wrist", "box"), sides, "both", ("slow", "fast"))


def test_both_sides_lose_what_lies_above_half_the_rate(found):
    assert found.activities == ("slow", "fast")
    assert [variant.value for variant in found.tried] == [*VALUES[RATE], 4, 2, *VALUES[BITS], *VALUES[ALONE]]
    assert (found.f1[:, 0] > 0.9).all()
    assert (found.loss[:, found.rows(FORCE_RANGE), 0] < 0.1).all()
    assert (found.low <= found.high).all()
    assert (found.steps(RATE)[:, 0] >= 1).all()


def test_range_and_resolution_come_last_to_the_last_bit():
    made = side(simulated(PART, HZ, SPEC), 200.0, 2)
    for knob in (RATE, FORCE_RANGE, BITS, ALONE):
        config = variants(made.usual, knob, VALUES[knob])[-1].config
        whole = [config.sensor_model().apply(one, config.seed) for one in made.recordings]
        features = site_windows(whole, config.windows).features
        np.testing.assert_array_equal(made.windows(config, "both").features, features)


def test_a_simulation_that_is_what_was_worn_is_never_off(found):
    same = found._replace(loss=np.stack([found.loss[0]] * 2))
    simulation, spoken, nothing, all_of_it = verdicts([same])
    assert (simulation.within, simulation.same, simulation.apart) == (1.0, 1.0, 0.0)
    assert simulation.met
    assert (simulation.cases, spoken.cases) == (2 * 3, 3)  # of the box guesses alone would tell as much
    assert nothing.apart == all_of_it.apart == pytest.approx(np.abs(found.loss[0]).mean())


def test_a_simulation_two_steps_off_fails(found):
    loss = np.zeros_like(found.loss)
    loss[0, found.rows(RATE)] = 0.5
    off = verdicts([found._replace(loss=loss)])[0]
    assert (off.within, off.met) == (pytest.approx(2 / 3), False)


def test_sites_of_which_need_is_silent_are_judged_apart(found):
    """There nothing is said, so nothing said is wrong."""
    loss = np.zeros_like(found.loss)
    loss[0, found.rows(RATE), 1] = 0.5
    low = found._replace(loss=loss, f1=np.array([[0.9, 0.9], [0.9, 0.74]]))
    whole, spoken, *_ = verdicts([low])
    assert whole.within < 1 == spoken.within
    assert (whole.cases, spoken.cases) == (6, 3)
    assert len(verdicts([low._replace(f1=np.full((2, 2), 0.5))])) == 3


def test_the_page_has_a_line_a_site_and_a_picture(found, tmp_path):
    page = write_needs(tmp_path, [found])
    assert "| made, wrist |" in page
    assert "| made, box |" in page
    assert (tmp_path / "needs.png").stat().st_size > 5000
    assert (tmp_path / "losses.csv").read_text(encoding="utf-8").count("\n") == 1 + 2 * len(found.tried)
