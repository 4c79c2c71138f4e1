# SPDX-License-Identifier: GPL-3.0-or-later
"""Sites are scored by the mean of their sensors; people, or clips, are what is resampled and halved."""

import numpy as np

from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w_studies.validation.site_scores import site_scores

PEOPLE = [f"p{n}" for n in range(8)]


def made(spread=0.4):
    """Eight people, two activities, three clips each of four windows; the third of three sensors is deaf.

    Two people do the activities in a way of their own that the second does not understand.
    """
    rng = np.random.default_rng(0)
    activity, clip, subject, features = [], [], [], []
    for person in PEOPLE:
        for name, sign in (("up", 1), ("down", -1)):
            for number in range(3):
                odd = -1 if person in PEOPLE[:2] else 1
                means = np.array([sign, sign * odd, 0.0])[:, None]
                features.append(means + rng.normal(0, spread, (4, 3, 2)))
                activity += [name] * 4
                clip += [f"{name} {person} {number}"] * 4
                subject += [person] * 4
    return np.concatenate(features), np.array(activity), np.array(clip), np.array(subject)


def found():
    x, activity, clip, subject = made()
    whole = utility_map(
        x, CrossValidation(activity, clip, subject, np.ones(len(x), bool), ["up", "down"]), halvings=0
    )
    return whole, dict(zip(clip.tolist(), subject.tolist(), strict=True))


def test_a_site_is_the_mean_of_its_sensors():
    utility, person_of = found()
    alone = site_scores(utility, person_of)
    pooled = site_scores(utility, person_of, np.array([0, 1, 1]))
    np.testing.assert_allclose(alone.f1, utility.f1, atol=1e-6)
    np.testing.assert_allclose(pooled.f1, [alone.f1[0], alone.f1[1:].mean(axis=0)])
    np.testing.assert_allclose(pooled.samples[:, 1], alone.samples[:, 1:].mean(axis=1))
    assert pooled.halves.shape == (2, 200, 2, 2)


def test_people_vary_more_than_their_clips():
    """Two people defeat the second sensor throughout: it matters most which people are drawn."""
    utility, person_of = found()
    by_person, by_clip = site_scores(utility, person_of), site_scores(utility)
    widths = [np.diff(scores.mean_interval, axis=0)[0, 1] for scores in (by_person, by_clip)]
    assert widths[0] > 1.5 * widths[1]
    assert (by_person.units, by_person.n_units) == ("people", 8)
    assert (by_clip.units, by_clip.n_units, by_clip.n_windows) == ("clips", 48, 192)


def test_halves_share_no_person():
    """With both odd people in it a half of four names every second window wrongly; clips do not fall so."""
    utility, person_of = found()
    first, second = site_scores(utility, person_of).halves[:, :, 1].mean(axis=2)
    assert first.min() < 0.6
    assert second[first.argmin()] > 0.95
    assert np.corrcoef(first, second)[0, 1] < -0.9
    of_clips = site_scores(utility).halves[0, :, 1].mean(axis=1)
    assert of_clips.std() < 0.5 * first.std()
