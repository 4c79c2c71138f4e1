# SPDX-License-Identifier: GPL-3.0-or-later
"""A made ranking of which only what is said matters."""

from dataclasses import fields

import numpy as np

from w2w.core.ranking.utility import UtilityMap


def ranked(expected, reliability=0.8, clips=12, half_width=0.0625, **more):
    """A ranking of two activities whose patches move alike between resamples and err alike."""
    expected = np.asarray(expected, dtype=np.float32)
    given = dict.fromkeys((field.name for field in fields(UtilityMap)), np.zeros(0))
    given |= {
        "f1": np.stack([expected, expected], axis=1),
        "mean_samples": np.tile(expected, (8, 1)),
        "level": 0.95,
        "expected_mean": expected,
        "expected_f1": np.repeat(expected[:, None], 2, axis=1),
        "expected_low": expected - half_width,
        "expected_high": expected + half_width,
        "errors": 0.02 * np.random.default_rng(0).choice([-1.0, 1.0], size=(200, len(expected))),
        "reliability": reliability,
        "beats_average": 0.93,
        "posture": None,
        "activities": ("sit", "walk"),
        "truth": np.repeat([0, 1], clips),
        "clip": np.array([f"clip {number}" for number in range(2 * clips)]),
        "protocol": "5-fold cross-validation grouped by clip",
    }
    return UtilityMap(**{**given, **more})
