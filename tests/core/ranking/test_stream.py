# SPDX-License-Identifier: GPL-3.0-or-later
"""F1 in a stream where it is known: nothing lost, one activity lost, nothing told at all."""

from dataclasses import fields, replace

import numpy as np
import pytest

from w2w.core.findings.cautions import POSTURES, alone_caution
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.ranking import stream
from w2w.core.ranking.stream import Stream
from w2w.core.ranking.utility import ExpectedF1, UtilityMap
from w2w.core.selection.headline import by_posture
from w2w.core.windows.windows import WindowSpec

RATE, FOLDS = 50.0, 3
STANDING = np.array([0.0, 0.0, 9.8, 0.0, 0.0, 0.0])


@pytest.fixture(autouse=True)
def few_orders(monkeypatch):
    monkeypatch.setattr(stream, "MOST_ORDERS", 2)


def shaking(hertz, seconds, rng):
    """Shaking along x at a rate, from a drawn phase, about standing."""
    time = np.arange(round(seconds * RATE)) / RATE + rng.uniform()
    return STANDING + 4.0 * np.sin(2 * np.pi * hertz * time)[:, None] * [1, 0, 0, 0, 0, 0]


def still(seconds, _rng):
    return np.tile(STANDING, (round(seconds * RATE), 1))


def stream_of(*sensors, clips=6, fold=None, activity=None, seed=0):
    """Clips seen by sensors, each of which knows a signal for every activity: a function of seconds."""
    rng = np.random.default_rng(seed)
    activity = np.tile(np.arange(len(sensors[0])), clips) if activity is None else activity
    recordings = []
    for number in activity.tolist():
        seconds = rng.uniform(1.5, 5.0)
        signals = np.stack([sensor[number](seconds, rng) for sensor in sensors], axis=1)
        recordings.append(ImuRecording(signals[..., :3], signals[..., 3:], RATE))
    fold = np.arange(len(activity)) // len(sensors[0]) % FOLDS if fold is None else fold
    return Stream(
        lambda patches: [one.at(patches) for one in recordings], np.tile(STANDING, (len(sensors), 1)),
        SensorModel.ideal(), WindowSpec.of_length(2.0), activity, fold, np.ones(activity.max() + 1), seed,
    )  # fmt: skip


def waves(*hertz):
    return [lambda seconds, rng, of=one: shaking(of, seconds, rng) for one in hertz]


def test_what_differs_throughout_is_told_in_a_stream_as_on_clips():
    (found,) = stream_of(waves(1.0, 3.0, 8.0)).f1([[0]])
    assert found.by_clip == pytest.approx(1.0)
    assert found.orders.min() > 0.93  # half of some windows is standing


def test_two_activities_that_are_one_share_a_stream_by_chance():
    (found,) = stream_of(waves(1.0, 8.0, 8.0), clips=12).f1([[0]])
    assert found.orders[:, 0].min() > 0.93
    assert 0.3 < found.orders[:, 1:].mean() < 0.7


def test_who_stands_between_clips_is_no_false_alarm():
    (found,) = stream_of([still, *waves(1.0, 3.0)], clips=12).f1([[0]])
    assert found.orders.min() > 0.9  # though standing is taken for the still activity


def test_a_set_knows_what_any_of_its_patches_knows():
    worn = stream_of([still, *waves(1.0, 1.0)], [*waves(1.0, 1.0), still])
    first, second, both = (found.orders.mean() for found in worn.f1([[0], [1], [0, 1]]))
    assert max(first, second) < 0.8 < 0.9 < both


@pytest.mark.parametrize(("kept_apart", "least", "most"), [(True, 0.0, 0.7), (False, 0.85, 1.0)])
def test_copies_are_told_by_their_labels_only_if_they_are_not_kept_apart(kept_apart, least, most):
    rng = np.random.default_rng(1)
    motion = np.repeat(np.arange(10), 3)
    ways = 5.0 * rng.normal(size=(10, 6))  # of its own to each motion, and of no activity
    label = rng.permutation(10) % 2
    fold = motion % 5 if kept_apart else np.arange(30) % 3
    recordings = []
    for one in motion.tolist():
        signals = (STANDING + ways[one] + 0.3 * rng.normal(size=(150, 6)))[:, None]
        recordings.append(ImuRecording(signals[..., :3], signals[..., 3:], RATE))
    made = Stream(
        lambda patches: [one.at(patches) for one in recordings], STANDING[None], SensorModel.ideal(),
        WindowSpec.of_length(2.0), label[motion], fold, np.ones(2), 0,
    )  # fmt: skip
    assert least <= made.f1([[0]])[0].orders.mean() <= most


def test_the_same_seed_gives_the_same_bytes_and_another_nearly_the_same():
    one, again, other = (stream_of([still, *waves(1.0, 1.3)], seed=0) for _ in range(3))
    other = Stream(**{name: getattr(other, name) for name in FIELDS} | {"seed": 7})
    found = [made.f1([[0]])[0].orders for made in (one, again, other)]
    assert (found[0] == found[1]).all()
    assert found[0].mean() == pytest.approx(found[2].mean(), abs=0.05)
    assert (found[0] != found[2]).any()


FIELDS = ("read", "standing", "sensor", "spec", "activity", "fold", "weights")


def test_what_is_expected_in_a_stream_is_lower_and_no_surer():
    made = stream_of([still, *waves(1.0, 3.0)])
    by_clip = ExpectedF1(0.9, 0.85, 0.95)
    found = made.expected([0], by_clip)
    assert found.mean == pytest.approx(0.9 - made.f1([[0]])[0].loss.mean())
    assert found.high - found.low > by_clip.high - by_clip.low
    assert 0 <= found.low < found.mean < found.high <= 1


def test_an_interval_stays_narrow_where_clips_cut_out_are_all_told():
    made = stream_of([still, *waves(1.0, 3.0)])
    found = [made.expected([0], ExpectedF1(mean, mean - 0.05, mean)) for mean in (0.95, 1.0)]
    widths = [one.high - one.low for one in found]
    assert widths[1] < 1.5 * widths[0]


def test_one_sensor_loses_what_the_spots_lose_in_the_mean_and_a_set_what_it_loses():
    made = stream_of([still, *waves(1.0, 3.0)], [*waves(1.0), still, *waves(3.0)])
    own = [found.loss for found in made.f1([[0], [1], [0, 1]])]
    assert own[0] != pytest.approx(own[1])
    spots = Stream(**{name: getattr(made, name) for name in (*FIELDS, "seed")} | {"spots": [0, 1]})
    found = [found.loss for found in spots.losing([[0], [1], [0, 1]])]
    assert found[0] == pytest.approx((own[0] + own[1]) / 2)
    assert found[1] == pytest.approx(found[0])
    assert found[2] == pytest.approx(own[2])


def test_what_was_asked_for_before_changes_nothing():
    def noise(seconds, rng):
        return STANDING + rng.normal(size=(round(seconds * RATE), 6))

    found = []
    for before in ([[2]], [[0]]):
        made = replace(stream_of(waves(1.0, 1.2), waves(1.0, 1.1), [noise, noise]), spots=[0, 1])
        made.losing(before)
        found.append(made.f1([[0, 1]])[0])
    assert np.array_equal(found[0].orders, found[1].orders)
    assert np.array_equal(found[0].by_clip, found[1].by_clip)


def test_signals_of_a_patch_are_read_once():
    made, asked = stream_of(waves(1.0, 3.0), [still, *waves(3.0)]), []
    counted = Stream(
        **{name: getattr(made, name) for name in (*FIELDS, "seed")}
        | {"read": lambda patches: asked.extend(patches) or made.read(patches)}
    )
    counted.f1([[0]])
    counted.f1([[0, 1], [1]])
    counted.f1([[1, 0]])
    assert sorted(asked) == [0, 1]
    assert counted.f1([[1]])[0].by_clip == pytest.approx(made.f1([[1]])[0].by_clip)


def held(*directions):
    """Postures, by the direction of gravity in each, held with one and the same tremor."""
    turned = [np.array([*one, 0, 0, 0]) * 9.8 - STANDING for one in directions]
    return [lambda seconds, rng, of=one: shaking(2.0, seconds, rng) + of for one in turned]


def map_of(made):
    """A map of the patches of a stream, all with one expected F1."""
    f1 = np.full((len(made.standing), len(made.weights)), 0.9, np.float32)
    flat = dict.fromkeys(("expected_mean", "expected_low", "expected_high"), f1[:, 0])
    parts = {name: getattr(made, name) for name in (*FIELDS, "seed")}
    known = dict.fromkeys((each.name for each in fields(UtilityMap)), None) | flat
    named = {"activities": ("lie", "sit", "lean"), "weights": made.weights, "expected_f1": f1}
    return Stream(**parts | {"spots": [0]}).on_map(UtilityMap(**known | named))


@pytest.mark.parametrize(
    ("sensor", "told"),
    [(held((1, 0, 0), (0, 1, 0), (0, 0, -1)), True), (waves(1.0, 3.0, 8.0), False)],
    ids=["postures", "movements in one posture"],
)
def test_posture_alone_tells_postures_and_no_movements(sensor, told):
    found = map_of(stream_of(sensor, waves(1.0, 3.0, 8.0), clips=9))
    f1 = found.expected_mean[0]
    assert (by_posture(found, 0) > 0.95 * f1) == told
    assert told or by_posture(found, 0) < 0.6 * f1  # chance is a third
    assert np.isnan(by_posture(found, 1))  # no spot
    caution = alone_caution(found, "posture", by_posture(found, 0), 0)
    assert caution.text.startswith(POSTURES) == told == bool(caution.text)
