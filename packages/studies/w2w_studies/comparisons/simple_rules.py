# SPDX-License-Identifier: GPL-3.0-or-later
"""What people lose by rules that need no ranking: a habit, what is generally good, the most movement."""

import json
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.core.patches.body_parts import side_of

from ..validation.regret import lost
from ..validation.sites import SiteValidation

BELT, WRIST, GENERAL, ENERGY = "always a belt clip", "always the wrist", "best of other libraries", "energy"

RULES = BELT, WRIST, GENERAL, ENERGY

HABITS = {BELT: ("belt", "waist", "hip", "torso"), WRIST: ("wrist", "arm")}
"""Words in the names of the sites that a habit takes, of several each as often."""

PRIOR = Path(__file__).with_name("prior.json")
"""What `w2w study prior` made of four families of libraries."""


def regrets(
    found: SiteValidation, made: Sequence[ImuRecording], site_of: np.ndarray | None
) -> dict[str, float]:
    """Real macro F1 lost by each rule against the really best site; without habits that have no site.

    `made` are the simulated recordings, `site_of` the site of each of their sensors, by default its own.
    """
    owner = np.arange(len(found.sites)) if site_of is None else site_of
    habits = {
        rule: np.array([any(word in site.split() for word in words) for site in found.sites], dtype=float)
        for rule, words in HABITS.items()
    }
    of_sensors = {
        GENERAL: np.array([general().get(_region(name), 0.0) for name in made[0].sites]),
        ENERGY: np.mean([spread(one) for one in made], axis=0),
    }
    of_sites = {
        rule: np.array([values[owner == site].mean() for site in range(len(found.sites))])
        for rule, values in of_sensors.items()
    }
    scores = {rule: score for rule, score in habits.items() if score.any()} | of_sites
    real = found.real.mean[:, None]
    return {rule: float(lost(real, score[:, None])) for rule, score in scores.items()}


def spread(recording: ImuRecording) -> np.ndarray:
    """Spread of the size of specific force at each sensor, shape (N,), m/s2."""
    return np.nanstd(np.linalg.norm(recording.acc, axis=2), axis=0)


@cache
def general() -> dict[str, float]:
    """F1 above an average place, by region without its side."""
    return json.loads(PRIOR.read_text(encoding="utf-8"))["regions"]


def _region(sensor: str) -> str:
    """The region of a patch by its name, without side and number."""
    return side_of(re.sub(r" \d+$", "", sensor))[1]
