# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint centres of C3D files, under the labels that gait models give them; read by ezc3d."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..motion.source import UnusableMotion
from .facts import UNITS, PoseFacts
from .joint_sets import JOINT_SETS
from .naming import RawPose, plain_joint
from .paths import REQUIRED

JOINT_SET = "joint-centres"

LABELS = {
    "HJC": "hip", "KJC": "knee", "AJC": "ankle", "SJC": "shoulder", "EJC": "elbow", "WJC": "wrist",
    "FEP": "hip", "FEO": "knee", "TIO": "ankle", "HUP": "shoulder", "HUO": "elbow", "RAO": "wrist",
    "HNO": "hand", "TOE": "toe", "FIN": "hand",
}  # fmt: skip
"""What follows L or R in a label: joint centres (CGM, Theia, Visual3D), the segments' ends that Plug-in Gait
writes (a femur's P is the hip, its O the knee), and the markers of toe and finger."""

MIDDLE = {"HEDO": "head", "C7": "neck"}


def read_c3d_pose(path: Path) -> RawPose:
    """Joint centres, rate and unit of a C3D file.

    Raises
    ------
    UnusableMotion
        If ezc3d is missing, the file is damaged or holds markers alone.
    """
    try:
        import ezc3d
    except ImportError as error:
        raise UnusableMotion(f"C3D files are read by ezc3d (pip install ezc3d): {error}") from error
    try:
        found = ezc3d.c3d(str(path))
        point = found["parameters"]["POINT"]
        labels = [str(label) for label in point["LABELS"]["value"]]
        rate = float(np.ravel(point["RATE"]["value"])[0])
        unit = str(next(iter(point["UNITS"]["value"]), "")).strip().lower()
        positions = np.asarray(found["data"]["points"])[:3].transpose(2, 1, 0)
    except (OSError, KeyError, ValueError, IndexError, RuntimeError, StopIteration) as error:
        raise UnusableMotion(f"it cannot be read as C3D: {str(error).splitlines()[0]}") from error
    names: dict[str, int] = {}
    for number, label in enumerate(labels[: positions.shape[1]]):
        names.setdefault(_joint(label), number)
    _refuse_markers(labels, names)
    chosen = [joint for joint in JOINT_SETS[JOINT_SET].joints if plain_joint(joint) in names]
    places = [names[plain_joint(joint)] for joint in chosen]
    facts = PoseFacts(rate if rate > 0 else None, unit if unit in UNITS else None, None, JOINT_SET)
    return RawPose(positions[:, places], tuple(chosen), facts)


def _joint(label: str) -> str:
    """The plain name of a label's joint: ``Anna:LHJC`` is the left hip."""
    plain = label.rpartition(":")[2].strip()
    upper = plain.upper()
    if upper in MIDDLE:
        return MIDDLE[upper]
    if upper[:1] in ("L", "R") and upper[1:] in LABELS:
        return f"{'left' if upper[0] == 'L' else 'right'} {LABELS[upper[1:]]}"
    return plain_joint(plain)


def _refuse_markers(labels: list[str], names: Iterable[str]) -> None:
    missing = [name for name in REQUIRED if name not in set(names)]
    if missing:
        held = ", ".join(labels[:8]) + (", ..." if len(labels) > 8 else "") or "nothing"
        raise UnusableMotion(
            f"it names no joint centre of the {', '.join(missing)} (such as LHJC, LSJC), and holds {held}: "
            "W2W reads joint centres, not markers; let your gait model write them"
        )
