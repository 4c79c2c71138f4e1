# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of the regions of trunk, neck and head, from height and the way round."""

import numpy as np

from .body import JOINT_INDEX, Body, edges_of, midpoint, template

TRUNK_BANDS: dict[str, dict[str, float]] = template("regions.json")["trunk"]
"""Regions of the trunk by side and height, 0 at the hip joints and 1 at the shoulder joints.

Each ends at its number, the last of a side nowhere; "*" is for left or right.
"""

SECTOR_ENDS = (18.0, 58.0, 118.0, 162.0)
"""Degrees from the front at which the sides of `TRUNK_BANDS` end."""

SHOULDER_TOP = (0.93, 35.0, 150.0, 0.55)
"""The top of the shoulder: least height, least and largest azimuth, least upward part of the normal."""


def in_bands(bands: dict[str, float], along: np.ndarray) -> np.ndarray:
    """Name of the band that each place lies in; bands end at their numbers, the last one nowhere."""
    return np.array(list(bands))[np.searchsorted(list(bands.values())[:-1], along)]


def across(body: Body) -> np.ndarray:
    """How far each vertex lies to the left of the midline, metres, shape (V,)."""
    return body.vertices[:, 0] - body.joints[:, 0].mean()


def groin_height(body: Body, lower: np.ndarray) -> np.ndarray:
    """Height at which the legs begin, by vertex, shape (V,), metres.

    At the back it is the crotch's; in front it rises along the groin to the hip joint. `lower` marks the
    vertices of trunk and legs: only there may an edge across the midline be the crotch.
    """
    x = across(body)
    edges = edges_of(body.faces[lower[body.faces].all(axis=1)])
    crossing = edges[(x[edges[:, 0]] <= 0) & (x[edges[:, 1]] >= 0)]
    left, right = (body.joints[JOINT_INDEX[f"{side}_hip"]] for side in ("left", "right"))
    hip = (left + right) / 2
    crotch = body.vertices[crossing, 2].min() if len(crossing) else hip[2]
    out = np.abs(x) / abs(left[0] - right[0]) * 2
    rise = np.clip((out - 0.3) / 1.2, 0, 1) * (hip[2] - crotch)
    behind = body.vertices[:, 1] > hip[1] + 0.02 * body.height
    return np.where(behind, crotch, crotch + rise)


def trunk_names(body: Body, vertices: np.ndarray) -> np.ndarray:
    """Names of the regions of vertices of the trunk, shape (K,) of str."""
    hips, shoulders = (midpoint(body.joints, part)[2] for part in ("hip", "shoulder"))
    level = (body.vertices[vertices, 2] - hips) / (shoulders - hips)
    azimuth = _trunk_azimuth(body, vertices, level)
    sector = np.searchsorted(SECTOR_ENDS, azimuth)
    names = np.empty(len(vertices), dtype="U40")
    for code, bands in enumerate(TRUNK_BANDS.values()):
        here = sector == code
        names[here] = in_bands(bands, level[here])
    lowest, least, largest, upward = SHOULDER_TOP
    top = (level > lowest) & (azimuth > least) & (azimuth < largest)
    names[top & (body.vertex_normals[vertices, 2] > upward)] = "* shoulder top"
    return _with_side(body, vertices, names)


def neck_names(body: Body, vertices: np.ndarray) -> np.ndarray:
    """Names of the regions of vertices of the neck, shape (K,) of str."""
    azimuth = _azimuth_about(body, vertices, body.vertices[vertices, 1].mean())
    names = np.select([azimuth < 40, azimuth > 140], ["throat", "nape"], "* neck")
    return _with_side(body, vertices, names)


def head_names(body: Body, vertices: np.ndarray) -> np.ndarray:
    """Names of the regions of vertices of the head, shape (K,) of str.

    Heights are measured from the tip of the nose, 0, to the crown, 1.
    """
    points = body.vertices[vertices]
    x = across(body)[vertices]
    middle = np.abs(x) < 0.25 * np.abs(x).max()
    lower = points[:, 2] < points[:, 2].min() + 0.6 * np.ptp(points[:, 2])
    nose = points[middle & lower][np.argmin(points[middle & lower, 1])]
    level = (points[:, 2] - nose[2]) / (points[:, 2].max() - nose[2])
    # the corner of the chin: far forward and low
    chin = np.argmin(np.where(middle & (level < 0), points[:, 1] + 0.5 * points[:, 2], np.inf))
    under_jaw = level < level[chin] - 0.06
    azimuth = _azimuth_about(body, vertices, (points[:, 1].min() + points[:, 1].max()) / 2)
    rules = [
        (_ears(points, x, level), "* ear"),
        (under_jaw & (azimuth < 40), "throat"),
        (under_jaw & (azimuth < 100), "* neck"),
        (level > 0.82, "scalp crown"),
        (azimuth > 125, "back of head"),
        ((azimuth > 100) & (level < 0.35), "* behind ear"),
        ((azimuth > 75) & (level > 0.1), "* side of head"),
        ((azimuth > 48) & (level > 0.25), "* temple"),
        (azimuth > 48, "* jaw"),
        (level > 0.42, "forehead"),
        ((azimuth < 16) & (level > -0.12), "nose"),
        ((azimuth < 22) & (level > -0.33), "mouth"),
        (level < -0.33, "chin"),
        (level > 0.15, "* eye"),
    ]
    conditions, called = zip(*rules, strict=True)
    return _with_side(body, vertices, np.select(conditions, called, "* cheek"))


def _ears(points: np.ndarray, x: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Vertices of the ears: on either side, around what stands out most near the nose's height."""
    height = np.ptp(points[:, 2])
    near_nose = (level > -0.25) & (level < 0.55)
    ears = np.zeros(len(points), dtype=bool)
    for out in (x, -x):
        widest = out[near_nose].max()
        tips = near_nose & (out > 0.9 * widest)
        offset = np.abs(points[:, 1:] - points[tips, 1:].mean(axis=0))
        ears |= (offset[:, 0] < 0.09 * height) & (offset[:, 1] < 0.135 * height) & (out > 0.76 * widest)
    return ears


def _trunk_azimuth(body: Body, vertices: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Degrees around the trunk, 0 in front, 90 at the sides, 180 behind, independent of width and depth."""
    x, y = np.abs(across(body)[vertices]), body.vertices[vertices, 1]
    levels = np.linspace(level.min(), level.max(), 15)
    outlines = []
    for height in levels:
        near = np.abs(level - height) < 0.08
        outlines.append((np.percentile(x[near], 98), y[near].min(), y[near].max()))
    width, front, back = (np.interp(level, levels, column) for column in np.transpose(outlines))
    return np.degrees(np.arctan2(x / width, ((front + back) / 2 - y) / ((back - front) / 2)))


def _azimuth_about(body: Body, vertices: np.ndarray, middle: float) -> np.ndarray:
    """Degrees around a vertical axis at depth `middle`, 0 in front, 180 behind."""
    return np.degrees(np.arctan2(np.abs(across(body)[vertices]), middle - body.vertices[vertices, 1]))


def _with_side(body: Body, vertices: np.ndarray, names: np.ndarray) -> np.ndarray:
    """Put left or right for the "*" in names."""
    sides = np.where(across(body)[vertices] >= 0, "left", "right")
    return np.char.replace(names, "*", sides)
