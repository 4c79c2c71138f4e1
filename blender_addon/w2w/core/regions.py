# SPDX-License-Identifier: GPL-3.0-or-later
"""Body regions in a designer's words, found on any rigged body from its rest pose and weights.

Every vertex belongs to one region. Left and right are the wearer's. Around forearm, wrist and hand
the sides are dorsal (the back of the hand), volar (the palm), thumb side and little finger side;
elsewhere on the limbs front, back, lateral and medial.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components

from .body import Body
from .skeleton import JOINT_INDEX

GROUPS: dict[str, tuple[str, ...]] = {
    "head": ("head",),
    "neck": ("neck",),
    "trunk": ("pelvis", "spine1", "spine2", "spine3", "left_collar", "right_collar"),
    "left arm": ("left_shoulder", "left_elbow", "left_wrist", "left_hand"),
    "right arm": ("right_shoulder", "right_elbow", "right_wrist", "right_hand"),
    "left leg": ("left_hip", "left_knee", "left_ankle", "left_foot"),
    "right leg": ("right_hip", "right_knee", "right_ankle", "right_foot"),
}
"""Part of the body that each joint moves."""

TRUNK_BANDS: tuple[tuple[str, tuple[tuple[float, str], ...]], ...] = (
    ("centre front", ((0.05, "groin"), (0.25, "lower abdomen"), (0.45, "navel"), (0.62, "upper abdomen"), (9, "sternum"))),
    ("front", ((0.22, "{} front hip"), (0.5, "{} abdomen"), (0.62, "{} front ribs"), (0.9, "{} chest"), (9, "{} collarbone"))),
    ("side", ((0.22, "{} hip"), (0.5, "{} lateral oblique"), (0.75, "{} side ribs"), (9, "{} armpit"))),
    ("back", ((0.2, "{} buttock"), (0.45, "{} lower back"), (0.62, "{} middle back"), (0.97, "{} posterior scapula"), (9, "{} shoulder top"))),
    ("centre back", ((0.2, "sacrum"), (0.45, "lower spine"), (0.65, "middle spine"), (9, "upper spine"))),
)  # fmt: skip
"""Regions of the trunk by side and by height, 0 at the hip joints and 1 at the shoulder joints."""

TRUNK_SECTORS = (18.0, 58.0, 118.0, 162.0)
"""Azimuths (degrees from the front) at which the sides of `TRUNK_BANDS` end."""

SMALLEST_REGION = 3
"""Pieces of fewer vertices join a neighbour."""


def label_regions(body: Body) -> tuple[np.ndarray, tuple[str, ...]]:
    """Name the region of every vertex.

    Parameters
    ----------
    body : Body

    Returns
    -------
    codes : ndarray, shape (V,), int16
        Index into `names`.
    names : tuple of str
        Sorted names of the regions.
    """
    part = _parts(body)
    names = np.full(len(body.vertices), "", dtype=object)
    _name_trunk(body, part, names)
    _name_head(body, part, names)
    for side in ("left", "right"):
        _name_arm(body, part == f"{side} arm", side, names)
        _name_leg(body, part == f"{side} leg", side, names)
    unique, codes = np.unique(names.astype(str), return_inverse=True)
    return _contiguous(body.faces, codes).astype(np.int16), tuple(str(name) for name in unique)


def _joint(body: Body, name: str) -> np.ndarray:
    return body.joints[JOINT_INDEX[name]]


def _parts(body: Body) -> np.ndarray:
    """Part of `GROUPS` each vertex belongs to; trunk and legs part at the groin, not by weight."""
    names = list(GROUPS)
    totals = np.stack(
        [body.weights[:, [JOINT_INDEX[j] for j in GROUPS[n]]].sum(axis=1) for n in names], axis=1
    )
    part = np.array(names, dtype=object)[np.argmax(totals, axis=1)]
    low = np.isin(part, ["trunk", "left leg", "right leg"])
    side = np.where(_across(body) >= 0, "left leg", "right leg")
    below = body.vertices[:, 2] < _groin_height(body, low)
    part[low & below] = side[low & below]
    part[low & ~below] = "trunk"
    return part


def _across(body: Body) -> np.ndarray:
    """Distance to the left of the midline, shape (V,)."""
    return body.vertices[:, 0] - body.joints[:, 0].mean()


def _groin_height(body: Body, low: np.ndarray) -> np.ndarray:
    """Height at which the legs begin, by vertex: the crotch at the back, the groin line in front."""
    x = _across(body)
    edges = body.faces[:, [0, 1]][low[body.faces].all(axis=1)]
    across = edges[(x[edges[:, 0]] < 0) != (x[edges[:, 1]] < 0)]
    crotch = body.vertices[across, 2].min()
    hip = _joint(body, "left_hip")
    hip_width = abs(hip[0] - _joint(body, "right_hip")[0]) / 2
    rise = np.clip(np.abs(x) / hip_width - 0.3, 0, 1.2) / 1.2 * (hip[2] - crotch)
    behind = body.vertices[:, 1] > hip[1] + 0.02 * body.height
    return np.where(behind, crotch, crotch + rise)


def _name_trunk(body: Body, part: np.ndarray, names: np.ndarray) -> None:
    trunk = np.flatnonzero(part == "trunk")
    hips = (_joint(body, "left_hip")[2] + _joint(body, "right_hip")[2]) / 2
    shoulders = (_joint(body, "left_shoulder")[2] + _joint(body, "right_shoulder")[2]) / 2
    level = (body.vertices[trunk, 2] - hips) / (shoulders - hips)
    azimuth = _trunk_azimuth(body, trunk, level)
    sector = np.searchsorted(TRUNK_SECTORS, np.abs(azimuth))
    side = np.where(azimuth >= 0, "left", "right")
    for code, (_, bands) in enumerate(TRUNK_BANDS):
        band = np.searchsorted([top for top, _ in bands], level)
        for vertex in np.flatnonzero(sector == code):
            names[trunk[vertex]] = bands[band[vertex]][1].format(side[vertex])


def _trunk_azimuth(body: Body, trunk: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Angle around the trunk, degrees: 0 in front, 90 at the left, +-180 behind; width and depth even out."""
    x, y = _across(body)[trunk], body.vertices[trunk, 1]
    centres = np.linspace(level.min(), level.max(), 15)
    shape = []
    for centre in centres:
        near = np.abs(level - centre) < 0.08
        near &= np.abs(x) <= np.percentile(np.abs(x[near]), 98)
        shape.append((np.abs(x[near]).max(), (y[near].min() + y[near].max()) / 2, np.ptp(y[near]) / 2))
    width, middle, depth = (np.interp(level, centres, column) for column in np.transpose(shape))
    return np.degrees(np.arctan2(x / width, -(y - middle) / depth))


def _name_head(body: Body, part: np.ndarray, names: np.ndarray) -> None:
    x, y, z = _across(body), body.vertices[:, 1], body.vertices[:, 2]
    base, top = _joint(body, "head")[2], z.max()
    head = np.flatnonzero(part == "head")
    width = np.abs(x[head]).max()
    middle = (y[head].min() + y[head].max()) / 2
    for vertex in np.flatnonzero(np.isin(part, ["head", "neck"])):
        side = "left" if x[vertex] >= 0 else "right"
        level = (z[vertex] - base) / (top - base)
        azimuth = abs(np.degrees(np.arctan2(x[vertex], -(y[vertex] - middle))))
        names[vertex] = _head_name(part[vertex], side, level, azimuth, abs(x[vertex]) / width)


def _head_name(part: str, side: str, level: float, azimuth: float, out: float) -> str:
    if part == "neck":
        return "throat" if azimuth < 40 else "nape" if azimuth > 140 else f"{side} neck"
    if level > 0.8:
        return "scalp crown"
    if azimuth > 120:
        return "back of head"
    if out > 0.85 and azimuth > 60 and level < 0.6:
        return f"{side} ear"
    if azimuth > 50:
        return f"{side} temple" if level > 0.35 else f"{side} jaw"
    if level > 0.5:
        return "forehead"
    if azimuth > 18:
        return f"{side} cheek" if level < 0.25 else f"{side} eye"
    return "nose and mouth" if level > 0 else "chin"


def _name_arm(body: Body, members: np.ndarray, side: str, names: np.ndarray) -> None:
    chain = [f"{side}_{joint}" for joint in ("shoulder", "elbow", "wrist", "hand")]
    vertices = np.flatnonzero(members)
    along, bone = _along(body, vertices, chain)
    tops = (0.18, 0.85, 1.15, 1.8, 2.06, 2.9)
    sections = ("shoulder", "upper arm", "elbow", "forearm", "wrist", "hand", "fingers")
    section = np.array(sections, dtype=object)[np.searchsorted(tops, along)]
    dorsal = _dorsal(body, side)
    up_front = _around(body, vertices, chain, bone, np.array([0, -1.0, 0]), np.array([0, 0, 1.0]))
    hand_angle = _around(body, vertices, chain, bone, dorsal, np.array([0, -1.0, 0]))
    upper = _sector(up_front, ("front", "lateral", "back", "medial"))
    lower = _sector(hand_angle, ("dorsal", "thumb side", "volar", "little finger side"))
    for position, vertex in enumerate(vertices):
        name = section[position]
        if name == "fingers":
            names[vertex] = f"{side} fingers"
        elif name in ("shoulder", "upper arm", "elbow"):
            names[vertex] = f"{side} {name} {upper[position]}"
        else:
            names[vertex] = f"{side} {name} {lower[position]}"


def _name_leg(body: Body, members: np.ndarray, side: str, names: np.ndarray) -> None:
    chain = [f"{side}_{joint}" for joint in ("hip", "knee", "ankle", "foot")]
    vertices = np.flatnonzero(members)
    along, bone = _along(body, vertices, chain)
    outward = np.array([1.0 if side == "left" else -1.0, 0, 0])
    angle = _around(body, vertices, chain, np.minimum(bone, 1), np.array([0, -1.0, 0]), outward)
    sector = _sector(angle, ("front", "lateral", "back", "medial"))
    ankle = _joint(body, f"{side}_ankle")
    toes = _joint(body, f"{side}_foot")[1]
    for position, vertex in enumerate(vertices):
        point = body.vertices[vertex]
        where = sector[position]
        if point[2] < ankle[2] - 0.01 * body.height:
            names[vertex] = f"{side} {_foot_name(body, vertex, ankle, toes, where)}"
        elif along[position] > 2 and point[1] < ankle[1] - 0.03 * body.height:
            names[vertex] = f"{side} instep"
        elif along[position] > 1.82:
            names[vertex] = f"{side} ankle {where}"
        elif along[position] > 1.15:
            lower = {"front": "shin", "back": "calf"}
            names[vertex] = f"{side} {lower.get(where, f'lower leg {where}')}"
        elif along[position] > 0.85:
            names[vertex] = f"{side} knee {where}"
        elif along[position] < 0.3 and -60 < angle[position] - 45 < 60 and where != "medial":
            names[vertex] = f"{side} front pocket"
        else:
            names[vertex] = f"{side} thigh {where}"


def _foot_name(body: Body, vertex: int, ankle: np.ndarray, toes: float, where: str) -> str:
    y = body.vertices[vertex, 1]
    normal = body.vertex_normals[vertex]
    if y < toes:
        return "toes"
    if normal[2] < -0.7:
        return "sole"
    if y > ankle[1] + 0.01 * body.height:
        return "heel"
    return "instep" if normal[2] > 0.6 else f"foot {'lateral' if where == 'lateral' else 'medial'}"


def _along(body: Body, vertices: np.ndarray, chain: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Position of vertices along a chain of bones (bone number + fraction) and the bone nearest."""
    points = body.vertices[vertices]
    joints = np.array([_joint(body, name) for name in chain])
    positions, gaps = [], []
    for bone in range(len(chain) - 1):
        axis = joints[bone + 1] - joints[bone]
        fraction = (points - joints[bone]) @ axis / (axis @ axis)
        inside = np.clip(fraction, 0 if bone else None, 1 if bone < len(chain) - 2 else None)
        gaps.append(np.linalg.norm(points - joints[bone] - inside[:, None] * axis, axis=1))
        positions.append(bone + inside)
    nearest = np.argmin(gaps, axis=0)
    return np.stack(positions)[nearest, np.arange(len(points))], nearest


def _around(
    body: Body,
    vertices: np.ndarray,
    chain: list[str],
    bone: np.ndarray,
    zero: np.ndarray,
    quarter: np.ndarray,
) -> np.ndarray:
    """Angle of vertices around their bones, degrees: 0 towards `zero`, 90 towards `quarter`."""
    joints = np.array([_joint(body, name) for name in chain])
    axis = joints[bone + 1] - joints[bone]
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    spoke = body.vertices[vertices] - joints[bone]
    first = zero - axis * (axis @ zero)[:, None]
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(axis, first)
    second *= np.sign(second @ quarter)[:, None]
    return np.degrees(np.arctan2((spoke * second).sum(axis=1), (spoke * first).sum(axis=1)))


def _sector(angle: np.ndarray, names: tuple[str, str, str, str]) -> np.ndarray:
    """Name of the quarter turn, centred on 0, 90, 180 and 270 degrees, that each angle lies in."""
    return np.array(names, dtype=object)[np.round(angle / 90).astype(int) % 4]


def _dorsal(body: Body, side: str) -> np.ndarray:
    """Direction the back of the hand faces: normal to the flat of the hand, up or backward."""
    joints = [JOINT_INDEX[f"{side}_wrist"], JOINT_INDEX[f"{side}_hand"]]
    hand = body.vertices[body.weights[:, joints].sum(axis=1) > 0.5]
    normal = np.linalg.svd(hand - hand.mean(axis=0), full_matrices=False)[2][2]
    return normal if normal[1] + normal[2] > 0 else -normal


def _contiguous(faces: np.ndarray, codes: np.ndarray) -> np.ndarray:
    """Let stray pieces of a region join the neighbours they touch most, until each is in one piece."""
    adjacency = _adjacency(faces, len(codes))
    codes = codes.copy()
    while True:
        stray = _stray(adjacency, codes)
        if not stray.any():
            return codes
        votes = np.zeros((len(codes), codes.max() + 1), dtype=np.int32)
        links = adjacency.tocoo()
        useful = stray[links.row] & ~stray[links.col]
        np.add.at(votes, (links.row[useful], codes[links.col[useful]]), 1)
        movable = votes.any(axis=1)
        if not movable.any():
            return codes
        codes[movable] = votes[movable].argmax(axis=1)


def _stray(adjacency: csr_matrix, codes: np.ndarray) -> np.ndarray:
    """Vertices outside the largest connected piece of their region."""
    links = adjacency.tocoo()
    same = codes[links.row] == codes[links.col]
    graph = coo_matrix((np.ones(same.sum()), (links.row[same], links.col[same])), shape=adjacency.shape)
    pieces = connected_components(graph, directed=False)[1]
    sizes = np.bincount(pieces)
    order = np.lexsort((-np.arange(len(codes)), sizes[pieces]))
    largest = np.zeros(codes.max() + 1, dtype=np.int64)
    largest[codes[order]] = pieces[order]
    return (pieces != largest[codes]) | (sizes[pieces] < SMALLEST_REGION)


def _adjacency(faces: np.ndarray, n_vertices: int) -> csr_matrix:
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = np.concatenate([edges, edges[:, ::-1]])
    graph = coo_matrix((np.ones(len(edges), np.int8), edges.T), shape=(n_vertices, n_vertices)).tocsr()
    graph.data[:] = 1
    return graph
