# SPDX-License-Identifier: GPL-3.0-or-later
"""How many clips and activities a result rests on, and where they are too few for an interval."""

from __future__ import annotations

from collections.abc import Sequence

from blender_addon.w2w.core.intervals import FEWEST_CLIPS
from blender_addon.w2w.core.utility import UtilityMap


def clip_counts(found: int, used: Sequence[str], utility: UtilityMap) -> dict[str, int]:
    """Clips found, used, ranked and skipped.

    Parameters
    ----------
    found : int
        Motion files of the library.
    used : sequence of str
        The activity of each clip that was turned into signals.
    utility : UtilityMap
        Only clips of its activities are trained on and tested.
    """
    ranked = sum(activity in utility.activities for activity in used)
    return {"found": found, "used": len(used), "ranked": ranked, "skipped": found - len(used)}


def counts_sentence(clips: dict[str, int], utility: UtilityMap) -> str:
    """The counts in words: what was found, used, ranked and left out."""
    names, left_out = len(utility.activities), len(utility.left_out)
    text = f"{clips['ranked']} of {clips['found']} clips ranked, in {names} activities"
    if left_out:
        one = left_out == 1
        text += (
            f"; {clips['used'] - clips['ranked']} clips could be used but belong to {left_out} "
            f"{'activity that' if one else 'activities that'} could not be ranked"
        )
    return f"{text}; {clips['skipped']} skipped"


def few_clips(count: int) -> str:
    """A caution where an interval comes from too few clips; empty where it does not."""
    if count >= FEWEST_CLIPS:
        return ""
    return f"from {count} clip{'' if count == 1 else 's'} only: too few for an interval"


def interval_caution(utility: UtilityMap) -> str:
    """A caution where the interval of the mean rests on activities of few clips; empty where it does not."""
    counts = utility.tested_clips()
    few = sum(count < FEWEST_CLIPS for count in counts)
    if not few:
        return ""
    return (
        f"{few} of {len(counts)} ranked activities have fewer than {FEWEST_CLIPS} clips (the fewest: "
        f"{min(counts)}), too few for an interval: the intervals of the mean are narrower than they should be"
    )
