# SPDX-License-Identifier: GPL-3.0-or-later
"""The test on the MIG HAR dataset, whose garment the paper cites: fixed before anybody here had its data."""

from __future__ import annotations

from collections.abc import Mapping

from w2w.core.imu.presets import preset
from w2w.core.ranking.windows import WindowSpec

from ..datasets.mighar import MIGHAR_RATE
from .dsads import RULES as SPORTS
from .mhad import BANDAI, HDM05, MIXAMO
from .protocol import BY_POSTURE, KINECT, Analysis, Protocol, Rule
from .umafall import CMU

_TAKEN = ("walking", "running", "ascending stairs", BY_POSTURE)

RULES = (
    Rule("typing", MIXAMO, r"(^|/)typing\.fbx$"),
    Rule("eating", MIXAMO, r"(^|/)eat(ing)?\.fbx$"),
    *(rule for rule in SPORTS if rule.activity in _TAKEN),
)
"""Writing, ironing, folding, brushing teeth, vacuuming and going down stairs are shown by no library."""

ACTIVITIES = ("walking", "running", "ascending stairs", "standing", "sitting", "typing", "eating")


def mighar(sites: Mapping[str, str | int]) -> Protocol:
    """The protocol for the sites at which a user placed the garment's sensors."""
    return Protocol(
        name="MIG HAR",
        real={
            "walking": ("walking",),
            "running": ("jogging",),
            "ascending stairs": ("goingupstairs",),
            "standing": ("standing",),
            "sitting": ("sitting",),
            "typing": ("typing",),
            "eating": ("eatingcookie", "eatingpasta"),
        },
        rules=RULES,
        sites=sites,
        analyses=(
            Analysis(
                "all activities",
                "The test: every activity that two clips show, one band for all sources.",
                ACTIVITIES,
                (HDM05, BANDAI, MIXAMO, CMU, KINECT),
                3.0,
            ),
            Analysis(
                "motion capture",
                "Without the Kinect, at W2W's band.",
                ACTIVITIES,
                (HDM05, BANDAI, MIXAMO, CMU),
                10.0,
            ),
        ),
        rate_hz=MIGHAR_RATE,
        sensor=preset("icm-20948"),
        kinect_hz=3.0,
        windows=WindowSpec(),
        use="both",
        bars={"regret": 0.03, "rho over ceiling": 0.8},
    )
