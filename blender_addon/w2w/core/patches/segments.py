# SPDX-License-Identifier: GPL-3.0-or-later
"""Regions gathered to parts of the body: the sides of the left wrist to "left wrist", that to "left arm"."""

from __future__ import annotations

from .body_parts import ARM, FOOT, HAND, HEAD, LEG, NECK, PARTS, SIDES

AROUND = ("shoulder", "upper arm", "elbow", "forearm", "wrist", "thigh", "knee", "lower leg", "ankle")
"""Parts that have a front and a back, or the like."""


def great_part(region: str) -> str:
    """Head, neck, torso, or the arm or leg with its side."""
    side, _, stem = region.partition(" ")
    for limb in ("arm", "leg"):
        if side in SIDES and stem in PARTS[limb]:
            return f"{side} {limb}"
    whole = segment(region)
    return whole if whole in ("head", "neck") else "torso"


def segment(region: str) -> str:
    """The part of the body that a region belongs to, with its side; regions of the torso stay as they are."""
    side, _, stem = region.partition(" ")
    if side not in SIDES:
        side, stem = "", region
    if stem in HEAD:
        return "head"
    if stem in NECK:
        return "neck"
    if stem in HAND:
        stem = "hand"
    elif stem in FOOT:
        stem = "foot"
    elif stem in ("calf", "shin"):
        stem = "lower leg"
    elif stem in (*ARM, *LEG):
        stem = next(part for part in AROUND if stem.startswith(part))
    return f"{side} {stem}".strip()
