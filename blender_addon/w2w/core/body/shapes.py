# SPDX-License-Identifier: GPL-3.0-or-later
"""Body shapes: the bundled body made female or male, tall, heavy, muscular, old, long-limbed.

What SMPL's betas are to SMPL (Loper et al. 2015), named targets from MakeHuman (CC0) are
here: displacements of vertices and joints in the T-pose, added up. Faces, vertex order and
skinning weights never change, so patches stay where they are.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from numbers import Real
from pathlib import Path

import numpy as np
import scipy

from ..files import load_arrays
from .body import TEMPLATES, Body

DENSITY = 985.0
"""Mean density of the human body, kg/m3, as in SHAPY (Choutas et al. 2022, CVPR)."""

LIMB_STEP = 0.1
"""Share of its length by which one unit of a limb's target changes an arm or a leg."""

YOUNG, OLD = 25.0, 90.0
"""Ages, years, of MakeHuman's young and old adults."""

RANGES: dict[str, tuple[float, float]] = {
    "gender": (-1.0, 1.0),
    "height": (1.40, 2.10),
    "weight": (35.0, 160.0),
    "muscle": (0.0, 1.0),
    "age": (YOUNG, OLD),
    "arms": (0.85, 1.15),
    "legs": (0.85, 1.15),
}
"""Allowed values of the parameters of `shaped`."""

MORPHOLOGIES: dict[str, dict[str, float]] = {
    "neutral": {},
    "female": {"gender": -1.0},
    "male": {"gender": 1.0},
    "short": {"height": 1.55},
    "tall": {"height": 1.90},
    "light": {"weight": 48.0},
    "heavy": {"weight": 90.0},
    "muscular": {"muscle": 0.8},
    "old": {"age": 75.0},
    "long-limbed": {"arms": 1.1, "legs": 1.1},
    "short-limbed": {"arms": 0.9, "legs": 0.9},
}
"""Bodies worth comparing in a study, by name, as parameters of `shaped`."""


@dataclass(frozen=True, eq=False)
class ShapeTargets:
    """Displacements of the bundled body's vertices and joints, metres."""

    names: tuple[str, ...]  # K of them
    vertices: np.ndarray  # (K, H, 3), of the left half and the middle, the first H vertices
    joints: np.ndarray  # (K, 24, 3)
    faces_digest: str  # SHA-256 of the faces (int32) of the body that they fit

    @classmethod
    def load(cls, path: str | Path) -> ShapeTargets:
        """Read what `tools/make_body` wrote."""
        needed = ("names", "vertices", "joints", "faces_digest")
        data = load_arrays(path, needed, "does not hold shape targets")
        vertices, joints = (data[name].astype(np.float64) for name in ("vertices", "joints"))
        return cls(tuple(data["names"].tolist()), vertices, joints, str(data["faces_digest"]))

    def fit(self, body: Body) -> bool:
        """Whether a body has the vertex order of these targets."""
        digest = hashlib.sha256(np.ascontiguousarray(body.faces, dtype=np.int32).tobytes()).hexdigest()
        return body.mirror is not None and digest == self.faces_digest


def shaped(
    body: Body,
    *,
    gender: float = 0.0,
    height: float | None = None,
    weight: float | None = None,
    muscle: float = 0.0,
    age: float = YOUNG,
    arms: float = 1.0,
    legs: float = 1.0,
) -> Body:
    """The bundled body in another shape.

    Vertices and joints move by a weighted sum of displacements, so they are linear in the
    targets; height and weight are met by solving for how much of their targets it takes.

    Parameters
    ----------
    body : Body
        The bundled body.
    gender : float, -1 to 1
        -1 female, 0 neutral, 1 male.
    height : float, 1.40 to 2.10, optional
        Height of the T-pose, metres; what follows from the rest if omitted.
    weight : float, 35 to 160, optional
        Kilograms, at `DENSITY` times the volume; what follows from the rest if omitted.
        What can be reached depends on the height: a slender and a stout body bound it.
    muscle : float, 0 to 1
        0 average, 1 a body builder.
    age : float, 25 to 90
        Years.
    arms, legs : float, 0.85 to 1.15
        Length of the arms (shoulder to wrist) and legs (hip to ankle) relative to the
        average of this gender.

    Returns
    -------
    Body
        Same faces, weights and vertex order; soles on z = 0.

    Raises
    ------
    ValueError
        If a parameter is out of its range, a height or weight cannot be reached, or the
        body is not the bundled one.

    Examples
    --------
    >>> tall = w2w.shaped(w2w.Body.bundled(), height=1.85)
    >>> round(float(np.ptp(tall.vertices[:, 2])), 2)
    1.85
    """
    given = {"gender": gender, "muscle": muscle, "age": age, "arms": arms, "legs": legs}
    given |= {name: value for name, value in (("height", height), ("weight", weight)) if value is not None}
    for name, value in given.items():
        low, high = RANGES[name]
        if not (isinstance(value, Real) and low <= value <= high):
            raise ValueError(f"{name} must lie between {low:g} and {high:g}, not {value!r}")
    if not isinstance(body, Body):
        raise ValueError(f"shaped takes a Body, such as Body.bundled(), not {body!r}")
    targets = bundled_targets()
    if body.mirror is None or not targets.fit(body):
        raise ValueError(f"{body.name!r} cannot be reshaped: the shape targets fit only W2W's bundled body")
    vertices, joints = _moved(body, body.mirror, targets, given)
    floor = np.array([0.0, 0.0, vertices[:, 2].min()])
    return replace(body, vertices=vertices - floor, joints=joints - floor, name=_name(body.name, given))


@lru_cache(maxsize=1)
def bundled_targets() -> ShapeTargets:
    """The shape targets that come with W2W."""
    return ShapeTargets.load(TEMPLATES / "shapes.npz")


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Volume enclosed by a closed mesh with outward faces, cubic metres."""
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return float(np.einsum("fa,fa->", a, np.cross(b, c)) / 6)


def mass(body: Body) -> float:
    """Mass of a body of mean density, kilograms."""
    return DENSITY * volume(body.vertices, body.faces)


def _moved(
    body: Body, mirror: np.ndarray, targets: ShapeTargets, given: dict[str, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and joints moved by targets, as tall and as stout as it takes to reach height and weight."""
    height, weight = given.get("height"), given.get("weight")

    def vertices_at(tallness: float, stoutness: float) -> np.ndarray:
        shares = _shares(targets.names, given, tallness, stoutness)
        half = np.tensordot(shares, targets.vertices, axes=1)
        moves = np.empty_like(body.vertices)
        moves[mirror[: len(half)]] = half * [-1, 1, 1]
        moves[: len(half)] = half
        return body.vertices + moves

    def tallness_at(stoutness: float) -> float:
        if height is None:
            return 0.0
        return _solve(lambda tall: float(np.ptp(vertices_at(tall, stoutness)[:, 2])), height, "height", "m")

    def weight_at(stoutness: float) -> float:
        return DENSITY * volume(vertices_at(tallness_at(stoutness), stoutness), body.faces)

    stoutness = 0.0 if weight is None else _solve(weight_at, weight, "weight", "kg")
    tallness = tallness_at(stoutness)
    shares = _shares(targets.names, given, tallness, stoutness)
    return vertices_at(tallness, stoutness), body.joints + np.tensordot(shares, targets.joints, axes=1)


def _shares(names: Sequence[str], given: dict[str, float], tallness: float, stoutness: float) -> np.ndarray:
    """How much of each target to add; tallness and stoutness are from -1 to 1."""
    shares = {"male": given["gender"]}
    for name in ("arms", "legs"):
        steps = (given[name] - 1) / LIMB_STEP
        shares |= {f"longer {name}": max(steps, 0.0), f"shorter {name}": max(-steps, 0.0)}
    for sex, share in (("female", (1 - given["gender"]) / 2), ("male", (1 + given["gender"]) / 2)):
        shares |= {
            f"{sex} muscular": share * given["muscle"],
            f"{sex} old": share * ((given["age"] - YOUNG) / (OLD - YOUNG)),
            f"{sex} taller": share * max(tallness, 0.0),
            f"{sex} shorter": share * max(-tallness, 0.0),
            f"{sex} heavier": share * max(stoutness, 0.0),
            f"{sex} lighter": share * max(-stoutness, 0.0),
        }
    return np.array([shares[name] for name in names])


def _solve(measure: Callable[[float], float], wanted: float, name: str, unit: str) -> float:
    """The argument between -1 and 1 at which an increasing measure has the wanted value."""
    low, high = measure(-1.0), measure(1.0)
    if not low <= wanted <= high:
        raise ValueError(
            f"{name}={wanted:g} {unit} is out of reach with the other parameters given: "
            f"choose {low:.3g} to {high:.3g} {unit}"
        )
    return float(scipy.optimize.brentq(lambda value: measure(value) - wanted, -1.0, 1.0, xtol=1e-12))


def _name(name: str, given: dict[str, float]) -> str:
    usual = {"gender": 0.0, "muscle": 0.0, "age": YOUNG, "arms": 1.0, "legs": 1.0}
    changed = {key: value for key, value in given.items() if usual.get(key) != value}
    if abs(given["gender"]) == 1:
        name = "male" if changed.pop("gender") > 0 else "female"
    return ", ".join([name, *(f"{key}={value:g}" for key, value in changed.items())])
