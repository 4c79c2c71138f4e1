# SPDX-License-Identifier: GPL-3.0-or-later
"""The test on UMAFall: fixed before any agreement was computed, and not changed since.

Its sites nearly tie: two halves of its people hardly agree about them, so what counts is regret.
"""

from dataclasses import replace

import numpy as np

from w2w.core.imu.recording import ImuRecording

from ..datasets.umafall import UMAFALL_RATE, read_umafall
from .protocol import BANDAI, CMU, HDM05, KINECT, MIXAMO, Protocol, Rule, usual_analyses

RULES = (
    Rule("clap", KINECT, r"^a4_(?P<who>s\d+)_t\d+$"),
    Rule("clap", MIXAMO, r"(^|/)clapping\.fbx$"),
    Rule("hands up", BANDAI, r"(^|/)dataset-\d_raise-up-both-hands_(?P<who>[a-z-]+)_\d+\.bvh$"),
    Rule("phone call", BANDAI, r"(^|/)dataset-\d_call_(?P<who>[a-z-]+)_\d+\.bvh$"),
    Rule("open a door", MIXAMO, r"(^|/)opening door inwards\.fbx$"),
    Rule("sit down or get up", KINECT, r"^a2[45]_(?P<who>s\d+)_t\d+$"),
    Rule("sit down or get up", MIXAMO, r"(^|/)(sit to stand|stand to sit)\.fbx$"),
    Rule("walk", BANDAI, r"(^|/)dataset-\d_walk_(?P<who>[a-z-]+)_\d+\.bvh$"),
    Rule("walk", CMU, r"(^|/)(006_01|06_01|007_12)\.bvh$"),
    Rule("walk", MIXAMO, r"(^|/)(aj@|unarmed )?walk(ing)?( forward)?(_inplace)?( \(\d+\))?\.fbx$"),
    Rule("walk", KINECT, r"^a23_(?P<who>s\d+)_t\d+$"),
    Rule("bend", HDM05, r"(^|/)(?P<who>bd|bk|dg|mm|tr)_depositFloor"),
    Rule("bend", BANDAI, r"(^|/)dataset-\d_bow_(?P<who>[a-z-]+)_\d+\.bvh$"),
    Rule("hop", HDM05, r"(^|/)(?P<who>bd|bk|dg|mm|tr)_hopBothLegs"),
    Rule("jog", HDM05, r"(^|/)(?P<who>bd|bk|dg|mm|tr)_jog"),
    Rule("jog", BANDAI, r"(^|/)dataset-\d_run_(?P<who>[a-z-]+)_\d+\.bvh$"),
    Rule("jog", MIXAMO, r"(^|/)run(ning)?(_inplace)?\.fbx$"),
    Rule("jog", KINECT, r"^a22_(?P<who>s\d+)_t\d+$"),
    Rule("lie down", HDM05, r"(^|/)lie_down/(?P<who>bd|bk|dg|mm|tr)_"),
    Rule("upstairs", MIXAMO, r"(^|/)(ascending stairs|running up stairs)\.fbx$"),
)

ACTIVITIES = tuple(dict.fromkeys(rule.activity for rule in RULES))

MOVING_S = 6.0
"""A trial lasts 15 s, of which lying or sitting down takes a few: its most moving stretch is used."""


def most_moving(recording: ImuRecording, seconds: float = MOVING_S) -> ImuRecording:
    """The stretch of a recording in which all sites together move most."""
    n = min(recording.n_samples, round(seconds * recording.rate))
    size = np.nan_to_num(np.linalg.norm(recording.acc, axis=2), nan=9.8)
    energy = np.concatenate([[0.0], np.square(np.diff(size, axis=0, prepend=size[:1])).sum(axis=1).cumsum()])
    start = int((energy[n:] - energy[:-n]).argmax())
    part = slice(start, start + n)
    return replace(recording, acc=recording.acc[part], gyr=recording.gyr[part])


UMAFALL = Protocol(
    name="UMAFall",
    file_help="npz of UMAFall.",
    read=lambda path: [most_moving(recording) for recording in read_umafall(path)[0]],
    rate_hz=UMAFALL_RATE,
    # on which side the wrist's and the ankle's sensors were worn is not known: the patches of both count
    sites={"chest": "sternum", "waist": "hip", "wrist": "wrist", "ankle": "ankle"},
    real={
        "clap": ("ClappingHands",),
        "hands up": ("HandsUp",),
        "phone call": ("MakingACall",),
        "open a door": ("OpeningDoor",),
        "sit down or get up": ("Sitting_GettingUpOnAChair",),
        "walk": ("Walking",),
        "bend": ("Bending",),
        "hop": ("Hopping",),
        "jog": ("Jogging",),
        "lie down": ("LyingDown_OnABed",),
        "upstairs": ("GoUpstairs",),
    },
    rules=RULES,
    analyses=usual_analyses(ACTIVITIES),
)
