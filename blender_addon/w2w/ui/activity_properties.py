# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of an activity: what part it takes, and its weight."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty

from . import counting, updates
from .state import without_updates

PARTS = (
    (
        counting.COUNTED,
        "Counted",
        "Count it in the mean and in the choice of sensors, by its weight",
        "CHECKBOX_HLT",
        0,
    ),
    (
        counting.BACKGROUND,
        "Background",
        "Do not confuse it with the others: trained against, but in no mean",
        "SELECT_SUBTRACT",
        1,
    ),
    (counting.LEFT_OUT, "Left Out", "Do as if it had not been there", "CHECKBOX_DEHLT", 2),
)


def _part(activity: W2W_PG_activity) -> int:
    return [name for name, *_ in PARTS].index(counting.part_of(activity))


def _set_part(activity: W2W_PG_activity, number: int) -> None:
    with without_updates():  # the part's own update follows
        counting.set_part(activity, PARTS[number][0])


class W2W_PG_activity(bpy.types.PropertyGroup):
    """An activity of the clips, or of their ranking."""

    name: StringProperty(name="Activity")
    use: BoolProperty(name="Use", description="Not left out", default=True, update=updates.reweigh)
    background: BoolProperty(
        name="Background", description="Trained against, and in no mean", update=updates.reweigh
    )
    part: EnumProperty(
        name="Part",
        description="What this activity counts",
        items=PARTS,
        get=_part,
        set=_set_part,
        update=updates.reweigh,
    )
    weight: FloatProperty(
        name="Weight",
        description="What this activity counts in the mean, beside 1 for the others; 0 is background",
        default=1.0,
        min=0.0,
        soft_max=10.0,
        precision=2,
        step=10,
        update=updates.reweigh,
    )
    given: StringProperty(options={"HIDDEN"})


CLASSES = (W2W_PG_activity,)
