# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of the regions of arms, hands, legs and feet, from the place along the bones and around them."""

import numpy as np
from scipy.sparse.csgraph import dijkstra

from ..rotations import frame_of
from .body import JOINT_INDEX, Body, edge_lengths, edges_of, template
from .region_trunk import in_bands

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
