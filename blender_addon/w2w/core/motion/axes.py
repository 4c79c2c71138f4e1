# SPDX-License-Identifier: GPL-3.0-or-later
"""The six axes that can be up in a file, and turns of a motion from one of them to z."""

from dataclasses import replace
from typing import Literal

import numpy as np

from ..rotations import smallest_rotation
from .source import SourceMotion

Up = Literal["x", "y", "z", "-x", "-y", "-z"]

UPS: tuple[Up, ...] = ("x", "y", "z", "-x", "-y", "-z")

AXES = np.concatenate([np.eye(3), -np.eye(3)])

TO_Z = dict(zip(UPS, smallest_rotation(AXES, np.array([0.0, 0.0, 1.0])).round() + 0.0, strict=True))
"""Rotations that turn an axis to z."""


def turned(vectors: np.ndarray, up: Up) -> np.ndarray:
    """Vectors or matrices (..., 3, n) as columns, with an axis that is up turned to z."""
    return vectors if up == "z" else TO_Z[up] @ vectors


def stood(source: SourceMotion, up: Up, read_as: Up) -> SourceMotion:
    """The motion of a file whose axis `up` points up, that was read as if another one did."""
    if up == read_as:
        return replace(source, up=up)
    turn = np.eye(4)
    turn[:3, :3] = TO_Z[up] @ TO_Z[read_as].T
    return replace(source, matrices=turn @ source.matrices, up=up)
