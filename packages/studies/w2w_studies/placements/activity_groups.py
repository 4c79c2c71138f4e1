# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's six groups of activities, its named activities, and which of a library stand for them."""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path, PurePosixPath

from w2w.core.csv_tables import read_table
from w2w.core.library.library import Library, LibraryError

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

ACTIVITIES = Path(__file__).with_name("paper_activities.csv")
"""The eighteen activities that the paper names, and what Mixamo calls clips that show them."""

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


def named_by_paper(library: Library) -> tuple[Library, dict[str, str]]:
    """The clips of the paper's activities, known by Mixamo's names of clips, and the groups of these.

    Case, spaces, numbers and what stands before an ``@`` do not count: ``X Bot@Mma Kick (2).fbx`` is a pivot
    kick.

    Raises LibraryError if no file has such a name.
    """
    rows = [row for _, row in read_table(ACTIVITIES, ("activity", "group", "mixamo_names")).rows]
    activity_of = {_letters(name): row["activity"] for row in rows for name in row["mixamo_names"].split(";")}
    clips = tuple(
        replace(clip, activity=activity)
        for clip in library.clips
        if (activity := activity_of.get(_letters(PurePosixPath(clip.file).stem)))
    )
    if not clips:
        raise LibraryError(
            f"{library.folder} holds no file that Mixamo calls one of the paper's activities: give "
            "--labels, a csv with columns file, activity, group"
        )
    named = replace(library, clips=clips, labelled_by="Mixamo's names of clips")
    return named, {row["activity"]: row["group"] for row in rows}


def _letters(name: str) -> str:
    """What two spellings of a clip's name have in common."""
    letters = re.sub(r"[^a-z]", "", re.sub(r"^.*@|\(\d+\)", "", name.lower()))
    return letters.removesuffix("inplace")
