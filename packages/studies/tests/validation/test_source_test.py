# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the source of a clip can be told within one activity, and where it cannot be asked."""

import numpy as np
import pytest

from w2w_studies.validation.site_windows import SiteWindows
from w2w_studies.validation.source_test import source_tests


def windows(shift):
    """Three movers a source, four clips each; sources differ by `shift` at the first site alone."""
    rng = np.random.default_rng(0)
    rows = [
        (activity, source, f"{source} {mover}", f"{activity} {source} {mover} {clip}")
        for activity in ("wave", "jump")
        for source in ("film", "Kinect")
        for mover in range(3)
        for clip in range(4)
        if (activity, source) != ("jump", "Kinect")
    ]
    activity, source, mover, clip = np.array(rows).T
    features = rng.normal(size=(len(rows), 3, 5))
    features[source == "Kinect", 0] += shift
    made = SiteWindows(features, activity, clip, mover, np.ones(len(rows), bool), {})
    return made, dict(zip(clip.tolist(), source.tolist(), strict=True))


def test_a_source_is_told_where_its_signals_differ():
    (found,) = source_tests(*windows(5.0), np.array([0, 1, 1]))
    assert (found.activity, set(found.sources)) == ("wave", {"film", "Kinect"})  # jump has one source
    assert found.f1[0] > 0.95
    assert found.f1[1] < 0.8


def test_a_source_with_one_mover_is_not_asked_for():
    made, source_of = windows(5.0)
    alone = made._replace(subject=np.where(made.subject == "Kinect 1", "Kinect 0", made.subject))
    alone = alone._replace(subject=np.where(alone.subject == "Kinect 2", "Kinect 0", alone.subject))
    assert source_tests(alone, source_of, np.array([0, 1, 1])) == []
    assert source_tests(made, source_of, np.array([0, 1, 1]))[0].f1.shape == (2,)
    assert pytest.approx(1.0, abs=0.1) == source_tests(made, source_of, np.array([0, 1, 1]))[0].f1[0]
