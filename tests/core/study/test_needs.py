# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor needs what tells its activities apart, and no more."""

import re
from dataclasses import replace

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel, Triad
from w2w.core.imu.synthesis import STANDARD_GRAVITY
from w2w.core.ranking.costs import Cost
from w2w.core.study.config import StudyConfig
from w2w.core.study.needs import LEAST_F1, NOTHING, PARTS, Loss, Need, Place
from w2w.core.study.ranking import LabelledClip
from w2w.core.study.variants import ALONE, FINEST_HZ, FORCE_RANGE, KNOBS, RATE, at_rate, variants, with_model

from ...rings import by_day

CLIPS = 6
TIME = np.arange(int(4 * FINEST_HZ)) / FINEST_HZ


def place_of(*activities, part=None, shuffled=None, f1=0.9):
    """Clips whose specific force along the skin is one of some functions of time, in noise."""
    rng = np.random.default_rng(3)
    clips, seen = [], []
    for number, force in enumerate(activities):
        for clip in range(CLIPS):
            acc = 0.3 * rng.normal(size=(len(TIME), 1, 3)) + [0, 0, STANDARD_GRAVITY]
            acc[:, 0, 0] += force(TIME + rng.uniform())
            name = f"{number} {clip}"
            seen.append(ImuRecording(acc, 0.01 * rng.normal(size=acc.shape), FINEST_HZ, clip=name))
            clips.append(LabelledClip(name, f"a{number}", motion_key=name))
    if shuffled is not None:
        labels = np.random.default_rng(shuffled).permutation([clip.activity for clip in clips])
        clips = [replace(clip, activity=str(label)) for clip, label in zip(clips, labels, strict=True)]
    config = with_model(StudyConfig(), part or SensorModel())
    return Place(clips, seen, 0, at_rate(config, 50.0), f1)


def swinging(hertz, force=2.0):
    return lambda time: force * np.sin(2 * np.pi * hertz * time)


def beating(g):
    """Square beats, four a second, a tenth of the time."""
    return lambda time: g * STANDARD_GRAVITY * ((4 * time) % 1 < 0.1)


@pytest.mark.later
def test_what_lies_at_7_hz_is_lost_below_14_hz():
    need = place_of(swinging(7.0), swinging(0.0)).need("wrist", (RATE, ALONE))
    assert need.cheapest(RATE).value == 20
    lost = need.of(RATE)[-2].cost
    assert lost.expected > 0.2
    assert lost.low > 0
    said, alone = need.sentence().split("; ")
    assert re.fullmatch(r"Works down to 20 Hz, at a cost of up to \.\d\d", said)
    assert re.match(r"accelerometer alone costs nothing \(-?\.\d\d to \.\d\d\), gyroscope alone", alone)


def test_a_part_whose_filter_stays_open_sees_it_folded_back():
    part = SensorModel(accelerometer=Triad(lowpass_hz=44.0), gyroscope=Triad(lowpass_hz=42.0))
    need = place_of(swinging(7.0), swinging(0.0), part=part).need("wrist", (RATE,))
    assert need.cheapest(RATE).value == 5


def test_beats_of_3_and_6_g_are_one_at_2_g():
    part = SensorModel(accelerometer=Triad(full_scale=16 * STANDARD_GRAVITY, lowpass_hz=90.0))
    need = place_of(beating(3), beating(6), part=part).need("wrist", (FORCE_RANGE,))
    assert need.cheapest(FORCE_RANGE).value == 4
    assert need.of(FORCE_RANGE)[-1].cost.expected > 0.2


@pytest.mark.parametrize("seed", by_day(range(10), range(40)))
def test_shuffled_labels_never_work_down_to_anything(seed):
    place = place_of(swinging(1.0), swinging(2.0), swinging(4.0), shuffled=seed)
    need = place.completed(place.need("wrist"))
    assert (need.losses, need.parts) == ((), ())
    assert need.sentence().startswith(NOTHING)


@pytest.mark.slow
def test_twice_is_the_same_to_the_last_bit():
    first, second = (
        place.completed(place.need("wrist", (RATE,)))
        for place in (place_of(swinging(1.0), swinging(3.0)) for _ in range(2))
    )
    assert first == second
    assert len(first.parts) == PARTS
    assert {part.value for part in first.parts} == {first.cheapest(RATE).value}


def test_each_knob_turns_one_thing_and_back():
    config = at_rate(StudyConfig(), 50.0)
    own = {name: knob.own(config) for name, knob in KNOBS.items()}
    assert [round(value, 3) for value in own.values()][:4] == [50, 8, 2000, 16]
    for name, knob in KNOBS.items():
        for variant in variants(config, name):
            now = {other: one.own(variant.config) for other, one in KNOBS.items()}
            if name not in ("noise", "alone"):  # which have no value of their own
                assert now.pop(name) == pytest.approx(variant.value)
                assert now == pytest.approx({key: own[key] for key in now})
                assert knob.own(knob.altered(variant.config, own[name])) == pytest.approx(own[name])


def test_a_sensor_left_out_reads_nothing():
    seen = place_of(beating(6)).seen[0]
    for variant, kept, lost in zip(
        variants(at_rate(StudyConfig(), 50.0), ALONE), ("acc", "gyr"), ("gyr", "acc"), strict=True
    ):
        read = variant.config.sensor_model().apply(seen, 0)
        assert np.ptp(getattr(read, kept)) > 0
        assert not getattr(read, lost).any()


def test_nothing_is_said_where_the_f1_that_is_shown_is_low_though_windows_tell_all():
    """F1 of a map is that of clips one after another: below it lies F1 of windows of one clip."""
    sensors = swinging(1.0), swinging(5.0)
    need = place_of(*sensors, f1=LEAST_F1 - 0.01).need("wrist", (RATE,))
    assert (need.f1, need.losses) == (LEAST_F1 - 0.01, ())
    assert need.sentence() == f"{NOTHING}: F1 is .74, below .75"
    said = place_of(*sensors, f1=LEAST_F1).need("wrist", (RATE,))
    assert said.f1 == LEAST_F1
    assert [loss.f1 for loss in said.losses] == [
        pytest.approx(max(LEAST_F1 - loss.cost.expected, 0)) for loss in said.losses
    ]


def test_the_cheapest_value_tried_is_a_bound():
    losses = tuple(Loss(RATE, rate, f"{rate} Hz", 0.9, Cost(0.0, -0.01, 0.01)) for rate in (25, 10, 5))
    assert Need("wrist", 0, {RATE: 50.0}, 0.9, losses=losses).sentence() == (
        "Works down to 5 Hz or less, at a cost of up to .01"
    )
