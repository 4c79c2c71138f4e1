# SPDX-License-Identifier: GPL-3.0-or-later
"""Body regions in a designer's words, found on any rigged body from its rest pose and weights.

Every vertex belongs to one region and every region is one piece. Left and right are the wearer's.
Around forearm and wrist the sides are dorsal (as the back of the hand), volar (as the palm), thumb
side and little finger side; elsewhere on the limbs front, back, lateral and medial. A part of a
limb may be meant by leaving the side out: "left wrist" is the four regions of the left wrist.
"""

from functools import lru_cache

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from .body import JOINT_INDEX, Body, edges_of, neighbours
from .region_names import across, arm_names, groin_height, head_names, leg_names, neck_names, trunk_names

PARTS: dict[str, tuple[str, ...]] = {
    "head": ("head",),
    "neck": ("neck",),
    "trunk": ("pelvis", "spine1", "spine2", "spine3", "left_collar", "right_collar"),
    "left arm": ("left_shoulder", "left_elbow", "left_wrist", "left_hand"),
    "right arm": ("right_shoulder", "right_elbow", "right_wrist", "right_hand"),
    "left leg": ("left_hip", "left_knee", "left_ankle", "left_foot"),
    "right leg": ("right_hip", "right_knee", "right_ankle", "right_foot"),
}
"""Part of the body that each joint moves."""

SMALLEST_REGION = 3
"""Regions of fewer vertices join a neighbour."""


@lru_cache(maxsize=8)
def regions_of(body: Body) -> tuple[np.ndarray, tuple[str, ...]]:
    """Region of every vertex: indices (V,), int16, into the names; those of the last bodies are kept.

    Names are in the alphabetical order of the place, left before right.
    """
    part = _parts(body)
    named = np.full(len(body.vertices), "", dtype="U40")
    named[part == "trunk"] = trunk_names(body, np.flatnonzero(part == "trunk"))
    named[part == "head"] = head_names(body, np.flatnonzero(part == "head"))
    named[part == "neck"] = neck_names(body, np.flatnonzero(part == "neck"))
    for side in ("left", "right"):
        named[part == f"{side} arm"] = arm_names(body, np.flatnonzero(part == f"{side} arm"), side)
        named[part == f"{side} leg"] = leg_names(body, np.flatnonzero(part == f"{side} leg"), side)
    # by place first, so that ties between neighbours fall the same way on both sides of the body
    names = sorted(
        set(named.tolist()), key=lambda name: (name.removeprefix("left ").removeprefix("right "), name)
    )
    code = {name: index for index, name in enumerate(names)}
    codes = _in_one_piece(body.faces, np.array([code[name] for name in named]))
    used, codes = np.unique(codes, return_inverse=True)
    codes = codes.astype(np.int16)
    codes.setflags(write=False)
    return codes, tuple(names[index] for index in used)


def _parts(body: Body) -> np.ndarray:
    """Part of `PARTS` each vertex belongs to; legs and neck part from the trunk by place, not by weight."""
    joints = [[JOINT_INDEX[joint] for joint in joints] for joints in PARTS.values()]
    totals = np.stack([body.weights[:, members].sum(axis=1) for members in joints], axis=1)
    part = np.array(list(PARTS))[np.argmax(totals, axis=1)]
    lower = np.isin(part, ["trunk", "left leg", "right leg"])
    leg = lower & (body.vertices[:, 2] < groin_height(body, lower))
    part[lower] = "trunk"
    part[leg] = np.where(across(body)[leg] >= 0, "left leg", "right leg")
    below_neck = body.vertices[:, 2] < body.joints[JOINT_INDEX["neck"], 2]
    part[(part == "neck") & below_neck] = "trunk"
    return part


def _in_one_piece(faces: np.ndarray, codes: np.ndarray) -> np.ndarray:
    """Let stray pieces of a region join the neighbours they touch most, until each is in one piece."""
    links = neighbours(edges_of(faces), len(codes)).tocoo()
    codes = codes.copy()
    while True:
        stray = _stray(links, codes)
        useful = stray[links.row] & ~stray[links.col]
        votes = np.zeros((len(codes), codes.max() + 1), dtype=np.int32)
        np.add.at(votes, (links.row[useful], codes[links.col[useful]]), 1)
        movable = votes.any(axis=1)
        if not movable.any():
            return codes
        codes[movable] = votes[movable].argmax(axis=1)


def _stray(links: coo_matrix, codes: np.ndarray) -> np.ndarray:
    """Vertices outside the largest connected piece of their region, or in a region that is too small."""
    same = codes[links.row] == codes[links.col]
    graph = coo_matrix((np.ones(same.sum()), (links.row[same], links.col[same])), shape=links.shape)
    pieces = connected_components(graph, directed=False)[1]
    sizes = np.bincount(pieces)
    by_size = np.argsort(sizes[pieces], kind="stable")
    largest = np.zeros(codes.max() + 1, dtype=np.int64)
    largest[codes[by_size]] = pieces[by_size]
    return (pieces != largest[codes]) | (sizes[pieces] < SMALLEST_REGION)
