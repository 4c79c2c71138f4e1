# SPDX-License-Identifier: GPL-3.0-or-later
"""Notes on the clips and labels behind a result, with cautions if clips are too few for an interval."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..imu.sensor import FULL_SCALE
from ..library.labels import LabelCheck, same_label
from ..ranking.f1 import FEWEST_CLIPS
from ..ranking.utility import UtilityMap
from ..study.ranking import LabelledClip
from ..wording import count, listed

TOO_FEW = "too few clips"
"""In a table's cell, instead of an interval."""


def counts_sentence(clips: dict[str, int], utility: UtilityMap) -> str:
    """The counts in words."""
    names, left_out = len(utility.activities), len(utility.left_out)
    text = f"{clips['ranked']} of {clips['found']} clips ranked, in {names} activities"
    if left_out:
        others = clips["used"] - clips["ranked"]
        belong = "belongs" if others == 1 else "belong"
        text += (
            f"; {count('clip', others)} could be used but {belong} to {count('activity', left_out)} that "
            "could not be ranked"
        )
    return f"{text}; {clips['skipped']} skipped"


def left_out_sentences(left_out: Mapping[str, str]) -> list[str]:
    """The activities left out and why, one sentence for each reason.

    Examples
    --------
    >>> left_out_sentences({"bow": "bow has no clip", "jump": "jump has no clip"})
    ['bow, jump: each has no clip']
    """
    names: dict[str, list[str]] = {}
    for name, reason in left_out.items():
        shared = reason.removeprefix(f"{name} ")
        names.setdefault(shared, []).append(name if shared != reason else "")
    return [
        f"{', '.join(group)}{': each' if len(group) > 1 else ''} {reason}" if group[0] else reason
        for reason, group in names.items()
    ]


def few_clips(clips: int) -> str:
    """A caution if an interval comes from too few clips; else ""."""
    return "" if clips >= FEWEST_CLIPS else f"from {count('clip', clips)} only: too few for an interval"


def interval_caution(utility: UtilityMap) -> str:
    """A caution if the interval of the mean rests on activities with few clips; else ""."""
    counts = utility.tested_clips()
    few = sum(clips < FEWEST_CLIPS for clips in counts)
    if not few:
        return ""
    return (
        f"{few} of {len(counts)} ranked activities {'has' if few == 1 else 'have'} fewer than {FEWEST_CLIPS} "
        f"clips (the fewest: {min(counts)}), too few for an interval: intervals of the mean are narrower "
        "than they should be"
    )


def interval_text(low: float, high: float, caution: str, digits: int = 3) -> str:
    """An interval, or that there are too few clips for one."""
    return TOO_FEW if caution else f"{low:.{digits}f} to {high:.{digits}f}"


def label_notes(check: LabelCheck) -> list[str]:
    """One sentence for each kind of oddity."""
    notes = [f"{check.note}."] if check.note else []
    for name, ways in check.spellings:
        if check.exact and len(ways) > 1:
            notes.append(f"{_quoted(ways)} count as different activities (--exact-labels).")
        else:
            hint = " (--exact-labels keeps them apart)" if len(ways) > 1 else ""
            notes.append(f"{merged_sentence(name, ways)}{hint}.")
    notes += [f"{merged_sentence(name, ways, 'subject')}." for name, ways in check.subjects]
    kinds = (
        (check.no_such_file, "row matches no file", "rows match no file"),
        (check.no_activity, "row has no activity or no file name", "rows have no activity or no file name"),
        (check.not_listed, "file is not listed", "files are not listed"),
    )
    for files, singular, plural in kinds:
        if files:
            notes.append(f"{len(files)} {singular if len(files) == 1 else plural}: {listed(files)}.")
    return notes


def merged_sentence(name: str, ways: Sequence[str], what: str = "activity") -> str:
    """A sentence on the spellings of a label that count as one."""
    if len(ways) == 1:
        return f"{_quoted(ways)} is encoded in two ways that look the same, and counts as one {what}"
    return f"{_quoted(ways)} count as one {what}, '{name}'"


def _quoted(names: Sequence[str]) -> str:
    return listed([f"'{name}'" for name in names], len(names))


def label_content(check: LabelCheck) -> dict[str, Any]:
    """All notes, with every file named."""
    return {
        "rows_without_file": list(check.no_such_file),
        "rows_without_activity": list(check.no_activity),
        "files_not_listed": list(check.not_listed),
        "spellings": {name: list(ways) for name, ways in check.spellings},
        "spellings_kept_apart": check.exact,
        "subjects": {name: list(ways) for name, ways in check.subjects},
        "notes": label_notes(check),
    }


LONG_WINDOW = 1.5
"""Windows longer than so many median clips are cautioned against: in use they hold more than one activity."""


def window_warning(length_s: float, median_s: float) -> str:
    """A caution against windows that are long for the clips, whose median lasts `median_s`; else ""."""
    if not median_s or length_s <= LONG_WINDOW * median_s:
        return ""
    return (
        f"Windows of {length_s:g} s are {length_s / median_s:.1f} times as long as the median clip "
        f"({median_s:.1f} s), which is repeated to fill them. In use each holds more than one activity, and "
        f"F1 is lower. Take windows of at most {math.floor(10 * LONG_WINDOW * median_s) / 10:g} s"
    )


def copies_sentence(copies: Sequence[tuple[str, str]]) -> str:
    """A sentence on the clips that are copies, each with the first that shows its motion; "" without any."""
    if not copies:
        return ""
    copied = "1 clip counts as a copy" if len(copies) == 1 else f"{len(copies)} clips count as copies"
    return (
        f"{copied} of another, by motion_key or by how the body moves, and no clip is tested on its copies: "
        + listed([f"{name} (of {first})" for name, first in copies])
    )


def full_scale_sentence(clips: Iterable[tuple[str, Mapping[str, Any]]]) -> str:
    """A caution on clips, given with their records, that read the sensor's full scale too often; else ""."""
    shares = {name: record["at_full_scale"] for name, record in clips if "at_full_scale" in record}
    if not shares:
        return ""
    most = max(shares, key=lambda name: shares[name])
    return (
        f"{count('clip', len(shares))} read the sensor's full scale in more than "
        f"{100 * FULL_SCALE:g} % of the samples (the most: {most}, {100 * shares[most]:.0f} %): look at the "
        "motion, or take a sensor of a wider range"
    )


def cut_sentence(clips: Iterable[tuple[str, Mapping[str, Any]]]) -> str:
    """A sentence on the clips, given with their records, that lost frames at their ends; "" without any."""
    cut = [f"{name} ({record['cut']})" for name, record in clips if "cut" in record]
    return f"{count('clip', len(cut))} cut at the ends: {listed(cut)}" if cut else ""


def subjects_sentence(clips: Sequence[LabelledClip]) -> str:
    """A sentence on the subjects whose clips show the motion of another subject's clip; "" without any."""
    subjects: dict[str, set[str]] = {}
    for clip in clips:
        subjects.setdefault(clip.motion_key, set()).add(same_label(clip.subject))
    shared = [clip for clip in clips if len(subjects[clip.motion_key]) > 1]
    if not shared:
        return ""
    subjects_in_words = listed(sorted({clip.subject for clip in shared}))
    return (
        f"{len(shared)} clips of {subjects_in_words} show the same motion as another subject's clip: "
        "each motion is tested with the first of its subjects, and never trained on then"
    )
