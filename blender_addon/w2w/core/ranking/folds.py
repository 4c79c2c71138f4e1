# SPDX-License-Identifier: GPL-3.0-or-later
"""Split windows into folds that never share a clip."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..library.labels import same_label

ALWAYS_TRAIN = -1
"""Fold of windows that every fold trains on and none tests."""

SUBJECT_OUT = "leave one of"
"""First words of the protocol where subjects are left out."""


def grouped_folds(activity: np.ndarray, group: np.ndarray, folds: int = 5, seed: int = 0) -> np.ndarray:
    """Fold of each window, shape (W,), int, 0 to `folds` - 1: each activity spread as its groups allow.

    An activity with at least two groups is in at least two folds as long as no group
    holds several activities, so that whatever is tested has been trained; scikit-learn's
    StratifiedGroupKFold balances the counts but does not promise that. A `group` (W,), the clip or the clips
    that are one motion, stays together; `seed` decides which groups come together.
    """
    _, activity_index = np.unique(activity, return_inverse=True)
    _, group_index = np.unique(group, return_inverse=True)
    windows = np.zeros((group_index.max(initial=-1) + 1, activity_index.max(initial=-1) + 1))
    np.add.at(windows, (group_index, activity_index), 1.0)
    share = windows / windows.sum(axis=0)
    size = windows.sum(axis=1)
    shuffled = np.random.default_rng(seed).permutation(len(windows))
    biggest_first = shuffled[np.argsort(-share[shuffled].max(axis=1), kind="stable")]
    filled, load = np.zeros((folds, windows.shape[1])), np.zeros(folds)
    fold_of_group = np.empty(len(windows), dtype=np.int64)
    for index in biggest_first:
        same_activity = filled[:, share[index] > 0].sum(axis=1)
        fold = np.lexsort((load, same_activity))[0]
        filled[fold] += share[index]
        load[fold] += size[index]
        fold_of_group[index] = fold
    return fold_of_group[group_index]


def subject_folds(subject: np.ndarray, clip: np.ndarray) -> np.ndarray:
    """Fold of each window, shape (W,), int: one a subject (W,), however spelled, for leave-one-subject-out.

    `clip` (W,) is the clip or the clips that are one motion. One that several subjects show is in the fold of
    the first, so that no copy is trained on when it is tested. A ValueError says that a window has no
    subject, or that fewer than two remain.
    """
    subject, clip = np.asarray(subject), np.asarray(clip)
    spelled, fold = np.unique(subject, return_inverse=True)
    names, person = np.unique([same_label(name) for name in spelled.tolist()], return_inverse=True)
    fold = person[fold]
    clips, first, clip_index = np.unique(clip, return_index=True, return_inverse=True)
    if "" in names.tolist():
        without = len(np.unique(clip[names[fold] == ""]))
        raise ValueError(
            f"leave-one-subject-out needs a subject for every clip, and {without} of {len(clips)} have none: "
            "give labels with a column 'subject'"
        )
    people, fold = np.unique(fold[first][clip_index], return_inverse=True)
    if len(people) < 2:
        what = "clips" if len(names) < 2 else "motions"
        whose = spelled[person == people[0]][0]
        raise ValueError(f"leave-one-subject-out needs two subjects, and all {what} are of {whose}")
    return fold


def untestable(
    activity: np.ndarray, group: np.ndarray, activities: Sequence[str], fold: np.ndarray | None = None
) -> dict[str, str]:
    """The `activities` that cannot be cross-validated, each with the reason as a sentence.

    `activity`, `group` (the clip or the clips that are one motion) and `fold`, to find activities that are in
    one fold only, are those of each window, (W,).
    """
    activity, group = np.asarray(activity), np.asarray(group)
    reasons = {}
    for name in activities:
        windows = activity == name
        n_groups = len(np.unique(group[windows]))
        if n_groups < 2:
            clips = "no clip" if n_groups == 0 else "only one clip"
            reasons[name] = f"{name} has {clips}; testing on a clip other than those trained on needs two"
        elif fold is not None and len(np.unique(np.asarray(fold)[windows])) < 2:
            reasons[name] = f"all clips of {name} fell into one fold, so it could not be trained when tested"
    return reasons


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


def check_testable(
    activity: Sequence[str], group: Sequence[str], subject: Sequence[str] | None = None
) -> None:
    """Refuse clips, with a ValueError, of which no two activities can be tested: before work is done on them.

    `activity` and `group` are each clip's label and name, or that of the clips that are one motion; `subject`
    is who moves, where subjects are left out.
    """
    names, labels, groups = sorted(set(activity)), np.asarray(activity), np.asarray(group)
    if subject is None:
        _check_two(names, untestable(labels, groups, names))
    else:
        deal(labels, groups, np.asarray(subject), names, 0, 0)


def _check_two(activities: Sequence[str], left_out: dict[str, str]) -> tuple[str, ...]:
    """The activities that are not left out; a ValueError if there are not two."""
    tested = tuple(name for name in activities if name not in left_out)
    if len(tested) < 2:
        there = f"only {tested[0]}" if tested else "none"
        why = f": {'; '.join(left_out_sentences(left_out))}" if left_out else ""
        how = "" if tested else ". Put all clips of an activity into one folder, or label them in a csv"
        raise ValueError(f"a ranking needs two activities that can be tested, and there is {there}{why}{how}")
    return tested


def deal(
    activity: np.ndarray,
    clip: np.ndarray,
    subject: np.ndarray | None,
    activities: Sequence[str],
    folds: int,
    seed: int,
) -> tuple[np.ndarray, tuple[str, ...], dict[str, str], str]:
    """Deal the windows of testable activities to folds; see `utility.utility_map`.

    Returns the fold of each window (W,), the activities tested, the others, each with the reason, and the
    protocol in words.
    """
    left_out = untestable(activity, clip, activities)
    candidates = _check_two(activities, left_out)
    rows = np.flatnonzero(np.isin(activity, candidates))
    fold = np.full(len(activity), ALWAYS_TRAIN)
    if subject is not None:
        fold[rows] = subject_folds(np.asarray(subject)[rows], clip[rows])
        protocol = f"{SUBJECT_OUT} {len(np.unique(fold[rows]))} subjects out"
    else:
        n_folds = min(folds, len(np.unique(clip[rows])))
        fold[rows] = grouped_folds(activity[rows], clip[rows], n_folds, seed)
        protocol = f"{n_folds}-fold cross-validation grouped by clip"
    left_out |= untestable(activity, clip, candidates, fold)
    return fold, _check_two(candidates, left_out), left_out, protocol
