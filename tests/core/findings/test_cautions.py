# SPDX-License-Identifier: GPL-3.0-or-later
"""What speaks against an answer: which cautions a ranking gets, how heavy they are, and in which words."""

from w2w.core.findings.cautions import (
    KNOW,
    STOPS,
    WEAKENS,
    cut_sentence,
    full_scale_sentence,
    window_caution,
)


def test_clips_at_full_scale_are_counted_and_the_worst_is_named():
    shares = {"still": 0.0, "step": 0.01, "jump": 0.031, "far": 0.97}
    about = [(name, {"at_full_scale": share} if share > 0.01 else {}) for name, share in shares.items()]
    said = full_scale_sentence(about)
    assert said.startswith(
        "2 clips read the sensor's full scale in more than 1 % of the samples (the most: far, 97 %)"
    )
    assert full_scale_sentence(about[:2]) == ""


def test_clips_that_lost_frames_are_named_with_which():
    about = [("walk", {"cut": "frame 0 cut off: a rest pose"}), ("run", {})]
    assert cut_sentence(about) == "1 clip cut at the ends: walk (frame 0 cut off: a rest pose)"
    assert cut_sentence(about[1:]) == ""


def test_a_window_of_one_and_a_half_median_clips_is_the_longest_that_stops_no_answer():
    assert window_caution(2.0, [2.0, 3.0]).text == ""
    assert window_caution(2.0, [1.9, 2.0, 3.0])[:2] == (
        KNOW,
        "1 of 3 clips is repeated to fill a window of 2 s",
    )
    assert window_caution(3.0, [2.0, 2.0])[:2] == (
        WEAKENS,
        "2 of 2 clips are repeated to fill a window of 3 s",
    )
    weight, text, _ = window_caution(4.0, [1.7, 1.72, 5.0])
    assert weight == STOPS
    assert text.startswith(
        "windows of 4 s are 2.3 times as long as the median clip (1.7 s), and 2 of 3 clips"
    )
    assert text.endswith("Take windows of at most 2.5 s")
