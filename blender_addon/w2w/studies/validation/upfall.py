# SPDX-License-Identifier: GPL-3.0-or-later
"""The test on UP-Fall: fixed before anybody here had its data, and not changed since.

Its last analysis came later: two of the nine people at hand lack the pocket's sensor.
"""

from ..datasets.upfall import UPFALL_RATE, read_upfall
from .dsads import RULES as SPORTS
from .protocol import BY_POSTURE, HDM05, Protocol, Rule, usual_analyses

ACTIVITIES = ("walking", "standing", "sitting", "picking up an object", "jumping")
USUAL = usual_analyses(ACTIVITIES, band=(8.0, "a band that 18 Hz holds"))
WITHOUT_POCKET = USUAL[0]._replace(
    name="everyone at four sites",
    why="Who lacks the pocket's sensor takes part at the other sites; added after the first run.",
    sites=("ankle", "belt", "neck", "wrist"),
)

UPFALL = Protocol(
    name="UP-Fall",
    file_help="UP-Fall's CompleteDataSet.csv, or a folder of its trials.",
    read=lambda path: read_upfall(path)[0],
    rate_hz=UPFALL_RATE,
    # which ankle and wrist is not stated in what was read: the patches of both sides count
    sites={
        "ankle": "ankle",
        "right pocket": "right front pocket",
        "belt": "hip",
        "neck": "neck",
        "wrist": "wrist",
    },
    real={name: (name,) for name in ACTIVITIES},
    rules=(  # no library shows people who lie still
        Rule("picking up an object", HDM05, r"(^|/)(?P<who>bd|bk|dg|mm|tr)_depositFloor"),
        *(rule for rule in SPORTS if rule.activity in ("walking", "jumping", BY_POSTURE)),
    ),
    analyses=(*USUAL, WITHOUT_POCKET),
)
