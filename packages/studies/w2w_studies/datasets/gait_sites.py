# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the nine sensors of the gait trial sat, on the body and on Vicon's skeleton.

The data set's documentation (gait-tech/gaittoolbox, docs/source/data.rst): pelvis, thighs, shanks and feet
"according to standard Xsens sensor placement" and two sensors more "near the ankles", slightly above, which
its files call LowLeg; LowLeg2 is the shank's own. Xsens's standard: the sacrum, the middle of the thigh, flat
on the shin below the knee, the bridge of the foot. Which way round a limb each looked is read from its own
orientation while the wearer stands: the face of an MTw is its z axis. The lever arms that the Vicon joints
want (`python -m w2w_studies.experiments.gait`) agree to a few centimetres, but are not used.
"""

from typing import NamedTuple

from w2w.core.body.landmarks import SensorSite


class Worn(NamedTuple):
    """A worn sensor's place."""

    on_body: str | SensorSite  # a region, or a point along a limb and the way it faces
    joint: str
    segment: str
    """Vicon's nearest joint and the orientation of the segment it sat on."""


THIGH, SHIN, ABOVE_ANKLE = 0.5, 0.4, 0.85
"""How far down the thigh, and the lower leg, the sensors sat."""


def _leg(side: str) -> dict[str, Worn]:
    letter, outward = side[0].upper(), {"left": 1.0, "right": -1.0}[side]

    def limb(start: str, end: str, fraction: float, direction: tuple[float, float, float]) -> SensorSite:
        return SensorSite("", None, (f"{side}_{start}",), (f"{side}_{end}",), fraction, direction)

    forward = (0.3 * outward, -1.0, 0.0)
    return {
        f"{letter}_UpLeg": Worn(limb("hip", "knee", THIGH, forward), f"{letter}FEO", f"q{letter}TH"),
        f"{letter}_LowLeg": Worn(
            limb("knee", "ankle", ABOVE_ANKLE, (outward, 0.2, 0.0)), f"{letter}TIO", f"q{letter}SK"
        ),
        f"{letter}_LowLeg2": Worn(limb("knee", "ankle", SHIN, forward), f"{letter}FEO", f"q{letter}SK"),
        f"{letter}_Foot": Worn(f"{side} instep", f"{letter}TIO", f"q{letter}FT"),
    }


SITES = {"Pelvis": Worn("sacrum", "PELV", "qRPV"), **_leg("left"), **_leg("right")}
"""The worn sensors by their names in the files."""
