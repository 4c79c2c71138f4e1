# SPDX-License-Identifier: GPL-3.0-or-later
"""The test on UP-Fall: fixed before anybody here had its data, and not changed since."""

from __future__ import annotations

from w2w.core.imu.presets import DEFAULT_SENSOR, preset
from w2w.core.ranking.windows import WindowSpec

from ..datasets.upfall import UPFALL_RATE
from .dsads import RULES as SPORTS
from .mhad import BANDAI, HDM05, MIXAMO
from .protocol import BY_POSTURE, KINECT, Analysis, Protocol, Rule
from .umafall import CMU

RULES = (
    Rule("picking up an object", HDM05, r"(^|/)(?P<who>bd|bk|dg|mm|tr)_depositFloor"),
    *(rule for rule in SPORTS if rule.activity in ("walking", "jumping", BY_POSTURE)),
)
"""Lying still is shown by no library; walking, jumping, and people who sit or stand as for DSADS."""

ACTIVITIES = ("walking", "standing", "sitting", "picking up an object", "jumping")

UPFALL = Protocol(
    name="UP-Fall",
    real={name: (name,) for name in ACTIVITIES},
    rules=RULES,
    sites={
        "ankle": "ankle",
        "right pocket": "right front pocket",
        "belt": "hip",
        "neck": "neck",
        "wrist": "wrist",
    },
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
            "Without the Kinect, at a band that 18 Hz holds.",
            ACTIVITIES,
            (HDM05, BANDAI, MIXAMO, CMU),
            8.0,
        ),
    ),
    rate_hz=UPFALL_RATE,
    sensor=preset(DEFAULT_SENSOR),
    kinect_hz=3.0,
    windows=WindowSpec(),
    use="both",
    bars={"regret": 0.03, "rho over ceiling": 0.8},
)
"""Which side the ankle's and the wrist's sensors were worn on is not stated in what was read: the patches of
both sides stand for them. All else as on UMAFall."""
