# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison with DSADS by the names of files, so that other libraries give the same.

No test: other comparisons with this data set had been seen when it was written (docs/evidence/people.md).
Windows, features, folds and bars are those of the others.
"""

from w2w.core.body.landmarks import SensorSite
from w2w.core.imu.presets import preset

from ..datasets.dsads import DSADS_RATE, read_dsads
from .protocol import BANDAI, BY_POSTURE, CMU, MIXAMO, Protocol, Rule, usual_analyses
from .umafall import RULES as DAILY

STAYING = (
    r"(^|/)((breathing |unarmed )?idle( 01)?|sitting( and pointing)?|typing|eat(ing)?|drinking|talkingmale|"
    r"pointing|texting while standing|standing ?greeting|head nod yes|stroke shaking head|clapping|beckoning)"
    r"\.fbx$"
)
"""Clips of people who stay where they are: their thighs say whether they sit or stand."""

_NAMES = {"walk": "walking", "jog": "running", "hop": "jumping", "upstairs": "ascending stairs"}

RULES = (
    *(rule._replace(activity=_NAMES[rule.activity]) for rule in DAILY if rule.activity in _NAMES),
    Rule("running", BANDAI, r"(^|/)dataset-\d_dash_(?P<who>[a-z-]+)_\d+\.bvh$"),
    Rule("playing basketball", CMU, r"(^|/)06_(0[45689]|15)\.bvh$"),
    Rule(BY_POSTURE, MIXAMO, STAYING),
)

_REAL = {
    "walking": ("walking in parking lot", "walking on flat treadmill"),
    "running": ("running on treadmill",),
    "standing": ("standing",),
    "sitting": ("sitting",),
    "ascending stairs": ("ascending stairs",),
    "jumping": ("jumping",),
    "playing basketball": ("playing basketball",),
}

DSADS = Protocol(
    name="DSADS",
    file_help="DSADS's folder, or an npz of it.",
    read=read_dsads,
    rate_hz=DSADS_RATE,
    # chest, wrists, and the outer side of the thighs just above the knees (Altun et al. 2010, section 2)
    sites={
        "torso": "sternum",
        "right arm": "right wrist",
        "left arm": "left wrist",
        "right leg": SensorSite("DSADS right leg", None, ("right_hip",), ("right_knee",), 0.85, (-1, 0, 0)),
        "left leg": SensorSite("DSADS left leg", None, ("left_hip",), ("left_knee",), 0.85, (1, 0, 0)),
    },
    real=_REAL,
    rules=RULES,
    analyses=usual_analyses(
        tuple(_REAL),
        "Every activity that two clips show, one band for all sources. Other comparisons with DSADS had "
        "been seen.",
    ),
    sensor=preset("xsens mtw awinda"),  # the nearest to the MTx that DSADS's subjects wore
)
