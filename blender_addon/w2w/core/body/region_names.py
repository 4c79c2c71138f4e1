# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of a body's regions: of trunk and head by height and the way round, of limbs by their bones."""

import numpy as np
from scipy.sparse.csgraph import dijkstra

from ..rotations import frame_of
from .body import JOINT_INDEX, Body, edge_lengths, edges_of, midpoint, template

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


ARM_SECTIONS: dict[str, float] = template("regions.json")["arm"]
"""Ends of the sections of the arm, in bones from the shoulder joint: 1 the elbow, 2 the wrist."""

LEG_SECTIONS: dict[str, float] = template("regions.json")["leg"]
"""Ends of the sections of the leg, in bones from the hip joint: 1 the knee, 2 the ankle."""

POCKET = (0.32, -15.0, 70.0)
"""Trouser pocket: how far down the thigh, and between which degrees from the front to the side."""

FINGERS = ("thumb", "index finger", "middle finger", "ring finger", "little finger")

FINGER_PROMINENCE = 0.1
"""How far a finger stands out from the hand at least, as a fraction of the hand's length."""

LATERAL_SIDES = ("front", "lateral", "back", "medial")
DORSAL_SIDES = ("dorsal", "thumb side", "volar", "little finger side")

FORWARD, UP = np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0])


def arm_names(body: Body, vertices: np.ndarray, side: str) -> np.ndarray:
    """Names of the regions of vertices (K,) of one arm, shape (K,) of str."""
    joints = _chain(body, side, ("shoulder", "elbow", "wrist", "hand"))
    along, bone = _along(body.vertices[vertices], joints)
    section = in_bands(ARM_SECTIONS, along)
    dorsal = _dorsal(body, side)
    lateral = _sector(_around(body.vertices[vertices], joints, bone, FORWARD, UP), LATERAL_SIDES)
    angle = _around(body.vertices[vertices], joints, bone, dorsal, FORWARD)
    place = np.where(np.isin(section, ["forearm", "wrist"]), _sector(angle, DORSAL_SIDES), lateral)
    names = np.char.add(np.char.add(section, " "), place)
    names[(section == "shoulder") & (lateral == "medial")] = "armpit"
    hand = section == "hand"
    facing = body.vertex_normals[vertices[hand]] @ dorsal
    edge = np.where(angle[hand] > 0, "hand thumb side", "hand little finger side")
    names[hand] = np.select([facing > 0.35, facing < -0.35], ["back of hand", "palm"], edge)
    for finger, members in _fingers(body, vertices[along > 2], joints, dorsal).items():
        names[np.isin(vertices, members)] = finger
    return np.char.add(f"{side} ", names)


def leg_names(body: Body, vertices: np.ndarray, side: str) -> np.ndarray:
    """Names of the regions of vertices (K,) of one leg, shape (K,) of str."""
    joints = _chain(body, side, ("hip", "knee", "ankle", "foot"))
    points = body.vertices[vertices]
    along, bone = _along(points, joints)
    section = in_bands(LEG_SECTIONS, along)
    outward = np.array([1.0 if side == "left" else -1.0, 0, 0])
    angle = _around(points, joints, np.minimum(bone, 1), FORWARD, outward)
    sector = _sector(angle, LATERAL_SIDES)
    names = np.char.add(np.char.add(section, " "), sector)
    names[names == "lower leg front"] = "shin"
    names[names == "lower leg back"] = "calf"
    deepest, least, largest = POCKET
    names[(along < deepest) & (angle > least) & (angle < largest)] = "front pocket"
    ankle = joints[2]
    foot = points[:, 2] < ankle[2] - 0.012 * body.height
    foot |= (along > 2) & (points[:, 1] < ankle[1] - 0.035 * body.height)
    names[foot] = _foot_names(points[foot], body.vertex_normals[vertices[foot], 2], joints, body.height)
    return np.char.add(f"{side} ", names)


def _foot_names(points: np.ndarray, upward: np.ndarray, joints: np.ndarray, height: float) -> np.ndarray:
    """Names on the foot; `upward` is the vertical part of the normals."""
    ankle, ball = joints[2], joints[3]
    forward = (points[:, 1] - ankle[1]) / (ball[1] - ankle[1])
    line = ankle[0] + forward * (ball[0] - ankle[0])
    lateral = (points[:, 0] - line) * np.sign(ankle[0]) > 0
    rules = [
        (points[:, 1] < ball[1] - 0.004 * height, "toes"),
        (upward < -0.6, "sole"),
        (points[:, 1] > ankle[1] + 0.012 * height, "heel"),
        (upward > 0.5, "instep"),
        (lateral, "foot lateral"),
    ]
    conditions, called = zip(*rules, strict=True)
    return np.select(conditions, called, "foot medial")


def _fingers(
    body: Body, vertices: np.ndarray, joints: np.ndarray, dorsal: np.ndarray
) -> dict[str, np.ndarray]:
    """Vertices of the five fingers, or of all together if five cannot be distinguished."""
    points = body.vertices[vertices]
    edges = edges_of(body.faces)
    edges = np.searchsorted(vertices, edges[np.isin(edges, vertices).all(axis=1)])  # positions in `vertices`
    ring = np.argsort(np.linalg.norm(points - joints[2], axis=1), kind="stable")[:8]  # around the wrist
    reach = dijkstra(edge_lengths(points, edges), indices=ring, min_only=True)
    reach = np.where(np.isfinite(reach), reach, 0)
    branches = _branches(edges, reach, FINGER_PROMINENCE * reach.max())
    axis = joints[3] - joints[2]
    if len(branches) != 5:
        return {"fingers": vertices[(points - joints[3]) @ axis > 0.35 * axis @ axis]}
    to_thumb = np.cross(dorsal, axis)
    to_thumb *= np.sign(to_thumb @ (FORWARD + UP))
    branches.sort(key=lambda branch: -points[branch].mean(axis=0) @ to_thumb)
    return {name: vertices[branch] for name, branch in zip(FINGERS, branches, strict=True)}


def _branches(edges: np.ndarray, height: np.ndarray, prominence: float) -> list[np.ndarray]:
    """Parts of a surface that stand out: branches of the merge tree of its height, from the tips down.

    The members of every branch that rises at least `prominence` above the saddle where it meets another.
    """
    neighbours: list[set[int]] = [set() for _ in height]
    for first, second in edges:
        neighbours[first].add(second)
        neighbours[second].add(first)
    members: dict[int, list[int]] = {}
    owner = np.full(len(height), -1)
    trunks: set[int] = set()
    branches: list[np.ndarray] = []
    for vertex in np.argsort(-height, kind="stable"):
        meeting = sorted({int(owner[other]) for other in neighbours[vertex]} - {-1})
        tall = [top for top in meeting if top not in trunks and height[top] - height[vertex] >= prominence]
        if len(meeting) > 1 and (len(tall) > 1 or any(top in trunks for top in meeting)):
            branches += [np.array(members[top]) for top in tall]
            trunks.update(meeting)
        # the highest tip, or the palm where fingers have met, goes on
        heir = max(meeting, key=lambda top: (top in trunks, height[top]), default=int(vertex))
        members.setdefault(heir, []).append(int(vertex))
        owner[vertex] = heir
        for top in meeting:
            if top != heir:
                owner[members[top]] = heir
                members[heir] += members.pop(top)
    return branches


def _chain(body: Body, side: str, names: tuple[str, ...]) -> np.ndarray:
    return body.joints[[JOINT_INDEX[f"{side}_{name}"] for name in names]]


def _along(points: np.ndarray, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place of points along a chain of bones (number of the bone + fraction), and their nearest bone."""
    places, gaps = [], []
    last = len(joints) - 2
    for bone in range(last + 1):
        axis = joints[bone + 1] - joints[bone]
        fraction = (points - joints[bone]) @ axis / (axis @ axis)
        fraction = np.clip(fraction, 0 if bone else None, 1 if bone < last else None)
        gaps.append(np.linalg.norm(points - joints[bone] - fraction[:, None] * axis, axis=1))
        places.append(bone + fraction)
    nearest = np.argmin(gaps, axis=0)
    return np.stack(places)[nearest, np.arange(len(points))], nearest


def _around(
    points: np.ndarray, joints: np.ndarray, bone: np.ndarray, zero: np.ndarray, quarter: np.ndarray
) -> np.ndarray:
    """Angle of points around their bones, degrees: 0 towards `zero`, 90 towards `quarter`."""
    first, second, _ = np.moveaxis(frame_of(zero, joints[bone + 1] - joints[bone]), -1, 0)
    second = second * np.sign(second @ quarter)[:, None]
    spoke = points - joints[bone]
    return np.degrees(np.arctan2((spoke * second).sum(axis=1), (spoke * first).sum(axis=1)))


def _sector(angle: np.ndarray, sides: tuple[str, str, str, str]) -> np.ndarray:
    """Name of the quarter turn, centred on 0, 90, 180 and 270 degrees, that each angle lies in."""
    return np.array(sides)[np.round(angle / 90).astype(int) % 4]


def _dorsal(body: Body, side: str) -> np.ndarray:
    """Direction the back of the hand faces: normal to the flat of the hand, up or backward."""
    joints = [JOINT_INDEX[f"{side}_wrist"], JOINT_INDEX[f"{side}_hand"]]
    hand = body.vertices[body.weights[:, joints].sum(axis=1) > 0.5]
    normal = np.linalg.svd(hand - hand.mean(axis=0), full_matrices=False)[2][2]
    return normal if normal[1] + normal[2] > 0 else -normal
