# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the pelvis of a person is who sits on a chair."""

from __future__ import annotations

import numpy as np

from .rehab_session import Session

SEAT_HEIGHT = 0.45
"""Height of the chair's seat, metres; clips vary it by up to 2.5 cm."""


def seated_pelvis(session: Session) -> tuple[float, float]:
    """y and z of the middle between the hip joints on the chair, with the ankles at y = 0; metres."""
    figure = session.figure
    # the hip joints are about 8 cm above the seat in a person of average size
    height = SEAT_HEIGHT + session.between(-0.025, 0.025) + 0.047 * figure.stature
    shank_lean = session.degrees_between(6.0, 17.0)
    knee_ahead = figure.shank * np.sin(shank_lean)
    knee_height = figure.ankle_height + figure.shank * np.cos(shank_lean)
    return -knee_ahead + float(np.sqrt(figure.thigh**2 - (knee_height - height) ** 2)), height
