# SPDX-License-Identifier: GPL-3.0-or-later
"""The test on UP-Fall: fixed before anybody here had its data, and not changed since.

Its last three analyses came later: two of the nine people at hand lack the pocket's sensor, and the labels of
sitting and standing clips go by the simulated thighs.
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
POSTURES = ("standing", "sitting")
BY_THIGHS = "The simulated thighs' tilt labels sitting and standing clips, so a thigh sensor can tell them:"
MERGED = USUAL[0]._replace(
    name="sitting and standing merged",
    why=f"{BY_THIGHS} here the two count as one activity; added after the test.",
    merged=POSTURES,
)
NEITHER = USUAL[0]._replace(
    name="neither sitting nor standing",
    why=f"{BY_THIGHS} here neither takes part; added after the test.",
    activities=tuple(activity for activity in ACTIVITIES if activity not in POSTURES),
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
    analyses=(*USUAL, WITHOUT_POCKET, MERGED, NEITHER),
)
