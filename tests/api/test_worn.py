# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of worn sensors are ranked by themselves: no motion and no body."""

import numpy as np
import pytest

import w2w
from w2w_studies.comparisons.unpaired import real_side
from w2w_studies.datasets.dsads import DSADS_ACTIVITIES, DSADS_RATE, DSADS_SITES
from w2w_studies.validation.dsads import DSADS

pytestmark = pytest.mark.usefixtures("few_orders")

PACES = {"walking": 1.0, "running": 2.5, "still": 0.0}


def swinging(pace, number, moves):
    """Eight seconds at 25 Hz of a sensor that moves at a pace, or at none."""
    noise = np.random.default_rng(number).normal(scale=0.3, size=(200, 6))
    swing = 4 * np.sin(2 * np.pi * pace * np.arange(200) / 25 + number)
    return noise + [0, 0, 9.81, 0, 0, 0] + (swing[:, None] if moves else 0)


def made(places, clips=6, people=3, lacking=()):
    """Recordings of three activities; sensors at `places` move or not, and some clips lack some."""
    labels = [(activity, f"person {n % people}") for activity in PACES for n in range(clips)]
    worn = {
        place: [
            None if (n, place) in lacking else swinging(PACES[activity], n, moves)
            for n, (activity, _) in enumerate(labels)
        ]
        for place, moves in places.items()
    }
    activities, subjects = zip(*labels, strict=True)
    return w2w.Recordings.from_arrays(worn, 25, activities, subjects)


@pytest.fixture(scope="module")
def ranking():
    return w2w.rank(made({"left wrist": True, "forehead": False, "my shoe": True}), by_subject=True)


def test_the_sensor_that_moves_is_the_best(ranking):
    assert ranking.names == ("left wrist", "forehead", "my shoe")
    assert ranking.names[ranking.best] != "forehead"
    assert ranking.mean[[0, 2]].min() > 0.95
    assert ranking.mean[1] < 0.6
    assert ranking.utility.protocol == "leave one of 3 subjects out"
    assert {score.name for score in ranking.answer.products} == set(ranking.names)
    forehead = ranking.compare("forehead", "left wrist")[1]
    assert forehead.name == "forehead"
    assert forehead.cost.expected > 0.2
    assert ranking.at("My Shoe") == [2]
    with pytest.raises(
        ValueError, match="no sensor was worn at 'belt'; there are left wrist, forehead, my shoe"
    ):
        ranking.at("belt")


def test_sets_cards_and_table_need_no_body(ranking):
    worn = ranking.wear_together(0.9, constraints=w2w.Constraints(forbid=("my shoe",)))
    assert ranking.names[worn.order[0]] == "left wrist"
    (card,) = ranking.advice.cards
    assert card.in_words().startswith(("Left wrist. ", "My shoe. "))
    assert "slip" not in card.in_words()
    assert [row["name"] for row in ranking._rows()] == list(ranking.names)


@pytest.mark.slow
def test_only_places_of_known_names_are_drawn(ranking, tmp_path):
    assert ranking.picture is None
    assert "<img" not in ranking._repr_html_()
    with pytest.raises(ValueError, match="my shoe"):
        ranking.heatmap()
    known = w2w.rank(made({"left wrist": True, "forehead": False}))
    known.heatmap(tmp_path / "body.png")
    assert "<img" in known._repr_html_()
    known.report(tmp_path / "known.html")
    assert "data:image/png" in (tmp_path / "known.html").read_text()


def test_the_report_says_the_answer(ranking, tmp_path):
    ranking.report(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert ranking.answer.sentence() in page
    assert "on\n  other people" in page
    assert "data:image/png" not in page
    assert "imulated from" not in page


def test_places_are_compared_on_the_same_clips():
    lacking = {(n, "my shoe") for n in (0, 7)}
    with pytest.warns(UserWarning, match="2 clips lack a sensor and take no part"):
        found = w2w.rank(made({"left wrist": True, "my shoe": True}, lacking=lacking))
    assert len(found.clips) == 16
    assert found.skipped[0] == ("recording 1", "no sensor was worn at my shoe")
    whole = made({"left wrist": True, "my shoe": True}, lacking=lacking).at("left wrist")
    assert len(w2w.rank(whole).clips) == 18


def test_labels_dealt_by_chance_are_not_recognised():
    """The same signals under other labels: nothing is left that a place could be better at."""
    given = list(made({"left wrist": True, "my shoe": True}, clips=10))
    dealt = np.random.default_rng(5).permutation([one.activity for one in given])
    shuffled = [
        one.labelled(one.sites, str(name), one.subject, one.clip)
        for one, name in zip(given, dealt, strict=True)
    ]
    with pytest.warns(UserWarning, match="map reliability"):
        found = w2w.rank(w2w.Recordings(shuffled))
    assert found.mean.max() < 0.6


def test_stretches_of_a_clip_are_never_split():
    """Two clips an activity in five stretches each: as many folds as clips, whatever the stretches."""
    labels = [(activity, clip) for activity in PACES for clip in range(2) for _ in range(5)]
    arrays = [swinging(PACES[activity], n, True) for n, (activity, _) in enumerate(labels)]
    names = [f"{activity} {clip}" for activity, clip in labels]
    recordings = w2w.Recordings.from_arrays({"wrist": arrays}, 25, [a for a, _ in labels], clips=names)
    with pytest.warns(UserWarning, match="fewer than"):
        found = w2w.rank(recordings)
    assert len(recordings) == 30
    assert [clip.name for clip in found.clips] == sorted(set(names), key=names.index)
    assert set(found.utility.clip) == set(names)


@pytest.mark.slow
def test_dsads_as_arrays_gives_the_f1_of_the_comparison_with_simulated_sensors(shared_data):
    """The same windows by the same classifier, by way of the arrays and of the studies' reader."""
    path = shared_data / "imu" / "dsads" / "dsads_acc_gyr_25hz.npz"
    if not path.exists():
        pytest.skip("DSADS is not here")
    activities = ["jumping", "playing basketball", "sitting"]
    analysis = DSADS.analyses[0]._replace(activities=tuple(activities))
    studied = real_side(DSADS, DSADS.read(path), analysis).windows.ranked(activities, by_subject=True)

    with np.load(path) as data:
        named = np.array([DSADS_ACTIVITIES[number - 1] for number in data["activity"]])
        kept = np.isin(named, activities)
        x, people = data["x"][kept], [f"p{number}" for number in data["subject"][kept]]
    worn = {place: x[:, :, number] for number, place in enumerate(DSADS_SITES)}
    recordings = w2w.Recordings.from_arrays(worn, DSADS_RATE, named[kept], people)
    found = w2w.rank(recordings, by_subject=True)
    np.testing.assert_allclose(found.f1, studied.f1, atol=0.01)
    assert np.argsort(found.mean).tolist() == np.argsort(studied.mean).tolist()
