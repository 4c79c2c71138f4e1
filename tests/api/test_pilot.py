# SPDX-License-Identifier: GPL-3.0-or-later
"""A pilot moves the level of a map to what people's recordings at a place show, and says how sure that is."""

from dataclasses import replace

import numpy as np
import pytest

import w2w

PEOPLE = ("Ada", "Ben", "Cy")
PLACE = "left forearm volar"
"""One of the 24 patches: a wrist is too far from each."""


@pytest.fixture(scope="module")
def wrist(signals, ranking):
    """What the simulated forearm reads, by clip, long enough for several windows."""
    patch = ranking.at(PLACE)[0]
    return [one.at([patch]) for one in signals]


def people(wrist, noise=0.5, place=PLACE, seed=0, shuffled=False, who=PEOPLE):
    """Recordings of people who move as the clips do, with noise of their own."""
    rng = np.random.default_rng(seed)
    found = []
    for person in who:
        activities = [one.activity for one in wrist]
        if shuffled:
            activities = rng.permutation(activities).tolist()
        for one, activity in zip(wrist, activities, strict=True):
            acc = np.tile(one.acc, (3, 1, 1)) + rng.normal(scale=noise, size=(3 * one.n_samples, 1, 3))
            gyr = np.tile(one.gyr, (3, 1, 1)) + rng.normal(scale=noise / 5, size=(3 * one.n_samples, 1, 3))
            made = w2w.ImuRecording(acc, gyr, one.rate, (place,), activity, person, f"{person} {one.clip}")
            found.append(made)
    return w2w.Recordings(found)


def test_people_who_move_as_the_clips_do_keep_the_level_and_noise_lowers_it(ranking, wrist):
    near, far = (ranking.with_recordings(people(wrist, noise)) for noise in (0.3, 200.0))
    assert near.worn[0].mean > far.worn[0].mean + 0.15
    assert far.f1().mean < near.f1().mean - 0.1
    assert near.place.expected == ranking.answer.f1.mean == far.place.expected
    assert near.f1().low < near.f1().mean <= near.f1().high
    worn = list(near.worn[0].under)
    own = near.f1(ranking.compare(PLACE)[0])
    assert own.mean == pytest.approx(near.expected_f1[worn].mean(), abs=1e-6)
    assert near.people == PEOPLE
    said = near.sentence()
    assert said.startswith(f"With your pilot ({PLACE}, 3 people, ")
    assert said.endswith(f"without: {ranking.answer.f1.mean:.2f}.".replace("0.", ".", 1))
    assert "Two more people (about " in near.next()


def test_the_order_of_places_that_were_not_worn_stays(ranking, wrist):
    found = ranking.with_recordings(people(wrist, 100.0))
    others = np.setdiff1d(np.arange(len(ranking.names)), found.worn[0].under)
    for column in range(len(ranking.activities)):
        before, after = ranking.utility.expected_f1[others, column], found.expected_f1[others, column]
        assert (np.diff(after[np.argsort(before)]) >= 0).all()


def test_labels_dealt_by_chance_give_a_level_at_chance_with_a_caution(ranking, wrist):
    found = ranking.with_recordings(people(wrist, 0.3, shuffled=True))
    assert found.worn[0].mean <= found.worn[0].chance < 0.75
    assert found.f1().mean < found.worn[0].chance + 0.1
    assert found.cautions[0].weight == "weakens the answer"
    assert "no better than chance" in found.cautions[0].text
    assert not ranking.with_recordings(people(wrist, 0.3)).cautions


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"place": "left wirst"}, "did you mean left wrist"),
        ({"place": "left wrist"}, "the nearest patch to .left wrist. is 10.9 cm away .left forearm volar"),
        ({"place": "my fridge"}, "called"),
        ({"who": ("Ada",)}, "two people at least; the recordings at left forearm volar name Ada"),
        ({"who": ("",)}, "name nobody"),
    ],
)
def test_what_says_too_little_is_refused(ranking, wrist, change, why):
    with pytest.raises(ValueError, match=why):
        ranking.with_recordings(people(wrist, **change))


def test_recordings_of_other_activities_or_none_are_refused(ranking, wrist):
    strange = [replace(one, activity="yodelling") for one in people(wrist)]
    with pytest.raises(ValueError, match="name nobody in activities of the study"):
        ranking.with_recordings(w2w.Recordings(strange))
    with pytest.raises(ValueError, match=r"left out Ada/a\.csv: it is short; of the rest: a pilot takes two"):
        ranking.with_recordings(w2w.Recordings(strange, (("Ada/a.csv", "it is short"),)))
    with pytest.raises(ValueError, match="takes Recordings"):
        ranking.with_recordings(["left wrist"])


def test_some_activities_without_a_gyroscope_at_another_rate_are_used_and_it_is_said(ranking, wrist):
    kept = [one for one in people(wrist) if one.activity != ranking.activities[0]]
    slow = [replace(one, acc=one.acc[::2], gyr=0 * one.gyr[::2], rate=one.rate / 2) for one in kept]
    found = ranking.with_recordings(w2w.Recordings(slow))
    said = " ".join(caution.text for caution in found.cautions)
    assert f"nothing was recorded of {ranking.activities[0]}" in said
    assert "acceleration alone" in said
    assert ranking.activities[0] not in found.worn[0].f1
    content = found.content()
    assert content["people"] == 3
    assert content["worn"][0]["place"] == PLACE
    assert content["without"] == round(ranking.answer.f1.mean, 4)


def test_two_places_are_worn_by_different_people_on_different_days(ranking, wrist):
    two = [*people(wrist, 0.3), *people(wrist, 0.3, ranking.names[0], 1, who=("Dan", "Eve"))]
    found = ranking.with_recordings(w2w.Recordings(two))
    assert [one.name for one in found.worn] == [PLACE, ranking.names[0]]
    assert len(found.people) == 5
    assert f"{PLACE} and {ranking.names[0]}, 5 people" in found.sentence()
