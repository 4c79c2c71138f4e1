# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's six groups of activities, and which activities of a library stand for them."""

from __future__ import annotations

from collections.abc import Mapping

from w2w.core.motion.library import Library

PAPER_GROUPS: tuple[str, ...] = (
    "locomotion_posture",
    "balance_intensive",
    "full_body_rotation",
    "object_manipulation",
    "asymmetric",
    "communicative_gesture",
)
"""Six groups of four activities each make the paper's 24."""

PER_GROUP = 4

FEWEST_MOTIONS = 2
"""An activity of one motion cannot be tested on another than those it was learned from."""


def choose_activities(
    library: Library, group_of: Mapping[str, str], per_group: int = PER_GROUP
) -> dict[str, tuple[str, ...]]:
    """Activities of each group that have the most motions, by alphabet among equals.

    `group_of`: group of each activity.
    `per_group`: most activities of a group.
    Returns each of `PAPER_GROUPS` with its activities; a group may have fewer than asked for, or none.
    Raises ValueError if fewer than two activities are left in all.
    """
    motions: dict[str, set[str]] = {}
    for clip in library.clips:
        motions.setdefault(clip.activity, set()).add(clip.motion_key or clip.name)
    chosen = {}
    for group in PAPER_GROUPS:
        members = [
            name
            for name, keys in motions.items()
            if group_of.get(name) == group and len(keys) >= FEWEST_MOTIONS
        ]
        members.sort(key=lambda name: (-len(motions[name]), name))
        chosen[group] = tuple(sorted(members[:per_group]))
    if sum(map(len, chosen.values())) < 2:
        raise ValueError(
            f"fewer than two activities with {FEWEST_MOTIONS} motions or more belong to one of the groups "
            f"{', '.join(PAPER_GROUPS)}: give a csv with columns activity, group"
        )
    return chosen
