# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of a body by landmarks: sensors of published methods, and places that are not a region's middle."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace

import numpy as np

from .body import Body
from .skeleton import JOINT_INDEX

SMPL_FACES_SHA256 = "9e96e167056f19d9dc0fe3533177ebd5230b203297c219cab15e9e72b313aed1"
"""Digest of SMPL's triangles (see `has_smpl_topology`): which vertices are joined, not where they lie."""


@dataclass(frozen=True)
class SensorSite:
    """A point of the skin by its place between joints, on any body.

    Parameters
    ----------
    name : str
        For a virtual sensor of a published method, method and place, e.g. "TransPose left forearm".
    smpl_vertex : int or None
        Vertex of SMPL that the method's code reads.
    start, end : tuple of str
        Joints between which it lies; of several, their middle.
    fraction : float
        How far from `start` to `end`.
    direction : tuple of float
        Which way from there to the skin, in the axes of the T-pose (left, back, up).
    """

    name: str
    smpl_vertex: int | None
    start: tuple[str, ...]
    end: tuple[str, ...]
    fraction: float
    direction: tuple[float, float, float]

    def vertex(self, body: Body) -> int:
        """Vertex of the site: the published one on SMPL's mesh, the nearest equivalent on others."""
        if self.smpl_vertex is not None and has_smpl_topology(body):
            return self.smpl_vertex
        start, end = (
            body.joints[[JOINT_INDEX[joint] for joint in joints]].mean(axis=0)
            for joints in (self.start, self.end)
        )
        spoke = body.vertices - (start + self.fraction * (end - start))
        direction = np.array(self.direction) / np.linalg.norm(self.direction)
        ahead = spoke @ direction
        aside = np.linalg.norm(spoke - ahead[:, None] * direction, axis=1)
        # where the ray leaves the body: near the ray, ahead of the bone and not beyond another part
        near = (ahead > 0) & (aside < 0.02 * body.height) & (ahead < 0.15 * body.height)
        return int(np.argmin(np.where(near, aside, np.inf)))


def _sites(methods: tuple[str, ...], *sites: SensorSite) -> tuple[SensorSite, ...]:
    """The same sites for several methods."""
    return tuple(replace(site, name=f"{method} {site.name}") for method in methods for site in sites)


def _limb_site(
    name: str,
    vertex: int | None,
    joints: tuple[str, str],
    fraction: float,
    direction: tuple[float, float, float],
) -> SensorSite:
    """A site on the limb that its name begins with the side of; `direction` is the left side's."""
    side = name.split()[0]
    start, end = ((f"{side}_{joint}",) for joint in joints)
    outward = direction[0] if side == "left" else -direction[0]
    return SensorSite(name, vertex, start, end, fraction, (outward, *direction[1:]))


def _trunk_site(
    name: str, vertex: int | None, level: float, direction: tuple[float, float, float]
) -> SensorSite:
    """A site on the trunk at a height of 0, the hip joints, to 1, the shoulder joints."""
    hips, shoulders = (("left_hip", "right_hip"), ("left_shoulder", "right_shoulder"))
    return SensorSite(name, vertex, hips, shoulders, level, direction)


_FOREARM, _THIGH, _LOWER_LEG = ("elbow", "wrist"), ("hip", "knee"), ("knee", "ankle")
_FOREARMS = (
    _limb_site("left forearm", 1961, _FOREARM, 0.86, (0, 0, 1)),
    _limb_site("right forearm", 5424, _FOREARM, 0.85, (0, 0, 1)),
)
_HEAD = SensorSite("head", 411, ("head",), ("head",), 0.0, (0, 0, 1))
_PELVIS = _trunk_site("pelvis", 3021, 0.25, (0, 1, 0))

SENSOR_SITES: tuple[SensorSite, ...] = (
    *_sites(
        ("DIP",),
        _limb_site("left forearm", 1962, _FOREARM, 0.86, (0, 0.2, 1)),
        _limb_site("right forearm", 5431, _FOREARM, 0.93, (0, -0.5, 0.9)),
        _limb_site("left lower leg", 1096, _LOWER_LEG, 0.35, (0.8, 0.6, 0)),
        _limb_site("right lower leg", 4583, _LOWER_LEG, 0.44, (0.8, 0.6, 0)),
        replace(_HEAD, smpl_vertex=412, direction=(0, -0.18, 1)),
        _PELVIS,
    ),
    *_sites(
        ("TransPose", "PIP", "PNP"),
        *_FOREARMS,
        _limb_site("left lower leg", 1176, _LOWER_LEG, 0.24, (-0.6, -0.8, 0)),
        _limb_site("right lower leg", 4662, _LOWER_LEG, 0.3, (-0.6, -0.8, 0)),
        _HEAD,
        _PELVIS,
    ),
    *_sites(
        ("IMUPoser", "MobilePoser"),
        *_FOREARMS,
        _limb_site("left thigh", 876, _THIGH, 0.37, (0, -1, 0)),
        _limb_site("right thigh", 4362, _THIGH, 0.37, (0, -1, 0)),
        _HEAD,
        _PELVIS,
    ),
    *_sites(("LIP",), *_FOREARMS, _trunk_site("upper chest", 3059, 1.08, (0, -1, 0)), _PELVIS),
)
"""Vertices that the published code of these methods reads as sensors.

DIP: Huang et al. 2018, doi:10.1145/3272127.3275108. TransPose: Yi et al. 2021,
doi:10.1145/3450626.3459786. PIP: Yi et al. 2022, doi:10.1109/CVPR52688.2022.01282. PNP: Yi et al.
2024, doi:10.1145/3641519.3657436. IMUPoser: Mollyn et al. 2023, doi:10.1145/3544548.3581392.
MobilePoser: Xu et al. 2024, doi:10.1145/3654777.3676461. LIP: Zuo et al. 2024, Loose Inertial Poser.
"""

PLACES: tuple[SensorSite, ...] = (
    *(_limb_site(f"{side} wrist dorsal", None, _FOREARM, 0.985, (0, 0, 1)) for side in ("left", "right")),
    *(_limb_site(f"{side} instep", None, ("ankle", "foot"), 0.55, (0, 0, 1)) for side in ("left", "right")),
    _trunk_site("sacrum", None, 0.157, (0, 1, 0)),
)
"""Where sensors sit in regions whose middle is elsewhere.

A watch lies at the joint, where the skin follows forearm and hand; the instep is the top of the arch, and
the region reaches to the ball of the foot; the sacrum's flat back is some 8 cm above the hip joints, and
the region reaches down between the buttocks.
"""


def has_smpl_topology(body: Body) -> bool:
    """Whether a body's triangles are SMPL's, vertex by vertex, whatever their order in the list."""
    faces = np.asarray(body.faces, dtype=np.int64)
    if faces.shape != (13776, 3):
        return False
    start = faces.argmin(axis=1)[:, None]
    turned = np.take_along_axis(faces, (start + np.arange(3)) % 3, axis=1)
    listed = turned[np.lexsort(turned.T[::-1])].astype("<i4")
    return hashlib.sha256(listed.tobytes()).hexdigest() == SMPL_FACES_SHA256
