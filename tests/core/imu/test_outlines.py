# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn of a recording: its least and most specific force by pieces, gaps as gaps."""

import numpy as np

from w2w.core.imu.recording_folder import PIECES, outlines

from ...phone_exports import motion, table

NAMES = ["time (s)", *(f"Acceleration {a} (m/s^2)" for a in "xyz")]


def test_a_recording_is_drawn_in_pieces_and_what_is_none_is_said(tmp_path):
    t, gravity, _, _ = motion(60)
    kept = (t < 20) | (t > 30)
    gravity[t == 45] *= 3
    table(tmp_path / "Ada" / "walk.csv", NAMES, t[kept], gravity[kept])
    (tmp_path / "notes.txt").write_text("nothing")
    found = outlines(tmp_path)
    ((file, why),) = found["skipped"]
    assert file == "notes.txt"
    assert "time" in why
    (one,) = found["recordings"]
    assert one["file"] == "Ada/walk.csv"
    assert one["seconds"] == round(len(t) / 50, 2)
    assert len(one["signal"]) == PIECES
    lost = [number for number, ends in enumerate(one["signal"]) if ends is None]
    assert np.allclose([lost[0], lost[-1]], [PIECES / 3, PIECES / 2], atol=2)
    assert [number for number, ends in enumerate(one["signal"]) if ends and ends[1] > 20] == [300]
    assert one["signal"][0] == [9.81, 9.81]


def test_a_short_one_has_as_many_pieces_as_samples(tmp_path):
    t, gravity, _, _ = motion(3)
    table(tmp_path / "walk.csv", NAMES, t, gravity)
    assert len(outlines(tmp_path)["recordings"][0]["signal"]) == len(t)
