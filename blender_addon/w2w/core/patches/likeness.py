# SPDX-License-Identifier: GPL-3.0-or-later
"""Our body in the proportions of somebody's own character, as far as its shape goes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..adopt.rest_pose import metres_per_unit
from ..body.body import Body
from ..body.shapes import RANGES, shaped
from ..body.skeleton import JOINT_INDEX
from .correspondence import Character

Joints = Mapping[int, np.ndarray] | np.ndarray

LIMBS = {"arms": ("shoulder", "elbow", "wrist"), "legs": ("hip", "knee", "ankle")}

SIDES = ("left", "right")


def likeness(character: Character, body: Body) -> dict[str, float]:
    """Parameters of `shapes.shaped` that give our body a character's proportions.

    Parameters
    ----------
    character : Character
    body : Body
        The bundled body.

    Returns
    -------
    dict of str to float
        Length of arms and legs by that of the trunk, within what shapes there are; and the height,
        where it is that of a person and can be reached.
    """
    joints, trunk = character.joints, _trunk(character.joints)
    found = {}
    for name, parts in LIMBS.items():
        ratio = _length(joints, parts) / np.linalg.norm(trunk)
        own = _length(body.joints, parts) / np.linalg.norm(_trunk(body.joints))
        found[name] = float(np.clip(ratio / own, *RANGES[name]))
    height = float(np.ptp(character.vertices @ trunk) / np.linalg.norm(trunk))
    try:
        metres = height * metres_per_unit(height)
        if RANGES["height"][0] <= metres <= RANGES["height"][1]:
            shaped(body, height=metres, **found)
            found["height"] = metres
    except ValueError:  # it is nobody's height, or none that goes with these limbs
        pass
    return found


def _length(joints: Joints, parts: tuple[str, ...]) -> float:
    chains = np.array([[joints[JOINT_INDEX[f"{side}_{part}"]] for part in parts] for side in SIDES])
    return float(np.linalg.norm(np.diff(chains, axis=1), axis=-1).sum() / 2)


def _trunk(joints: Joints) -> np.ndarray:
    """From between the hips to between the shoulders."""
    hips, shoulders = (
        np.mean([joints[JOINT_INDEX[f"{side}_{part}"]] for side in SIDES], axis=0)
        for part in ("hip", "shoulder")
    )
    return shoulders - hips
