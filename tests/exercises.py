# SPDX-License-Identifier: GPL-3.0-or-later
"""Four exercises of four people whose whole bodies move, stored as the demo's motions are."""

from pathlib import Path

from w2w.core.motion.examples import demo_motions
from w2w.core.motion.motion import Motion

STORED = Path(__file__).with_suffix(".npz")


def exercises(clips: int) -> dict[str, Motion]:
    """The first clips of each exercise, at most four."""
    return demo_motions(clips, STORED)
