# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether somebody who stays where they are sits or stands."""

import numpy as np

from w2w.core.body.body import JOINT_INDEX, Body
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms

SEATED, UPRIGHT = np.radians((75, 105)), np.radians((0, 30))
"""Range of the thighs' tilt from hanging down, in nine frames of ten."""


def posture(body: Body, motion: Motion) -> str:
    """The posture throughout, "sitting" or "standing", by both thighs, or ""."""
    joints = joint_transforms(body, motion)[1]
    tilts = []
    for side in ("left", "right"):
        thigh = joints[:, JOINT_INDEX[f"{side}_knee"]] - joints[:, JOINT_INDEX[f"{side}_hip"]]
        tilts.append(np.arccos(-thigh[:, 2] / np.linalg.norm(thigh, axis=1)))
    low, high = np.quantile(tilts, [0.05, 0.95])
    for name, (least, most) in (("sitting", SEATED), ("standing", UPRIGHT)):
        if least <= low and high <= most:
            return name
    return ""
