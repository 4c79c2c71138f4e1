# SPDX-License-Identifier: GPL-3.0-or-later
"""The six axes that can be up in a file, and whether people stand, lie or hang along them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, Self

import numpy as np

from ..body.body import JOINT_INDEX
from ..rotations import smallest_rotation, unit
from .source import SourceMotion

Up = Literal["x", "y", "z", "-x", "-y", "-z"]

UPS: tuple[Up, ...] = ("x", "y", "z", "-x", "-y", "-z")

AXES = np.concatenate([np.eye(3), -np.eye(3)])

TO_Z = dict(zip(UPS, smallest_rotation(AXES, np.array([0.0, 0.0, 1.0])).round() + 0.0, strict=True))
"""Rotations that turn an axis to z."""


def turned(vectors: np.ndarray, up: Up) -> np.ndarray:
    """Vectors or matrices (..., 3, n) as columns, with an axis that is up turned to z."""
    return vectors if up == "z" else TO_Z[up] @ vectors


def stood(source: SourceMotion, up: Up, read_as: Up) -> SourceMotion:
    """The motion of a file whose axis `up` points up, that was read as if another one did."""
    if up == read_as:
        return replace(source, up=up)
    turn = np.eye(4)
    turn[:3, :3] = TO_Z[up] @ TO_Z[read_as].T
    return replace(source, matrices=turn @ source.matrices, up=up)


SEEN_FRAMES = 200
"""Frames of a clip that are looked at."""

LIMBS = ("hip", "knee", "ankle", "shoulder")
"""Joints of both sides that show how a body stands."""

UPRIGHT = np.cos(np.radians(40))
"""A body is upright along an axis if the line from its feet to its shoulders leans from it by less."""

POISED = np.cos(np.radians(20))
"""It is poised along an axis if the middle of its trunk leans from above its feet by less."""

MOSTLY, THROUGHOUT = 0.5, 0.75
"""Shares of the frames that decide how a clip is, and that it is so all the time."""

STEADY, STEEP = 0.35, 0.7
"""The lowest joint of who stands rises and falls by less: leg lengths, or on stairs shares of the way."""

LEAPS, MISTAKEN = 1.5, 20.0
"""Leg lengths that nobody jumps, and by which the lowest joint rises only in another unit: no evidence."""

WALKS, BENDS = 1.0, 0.25
"""Leg lengths that nobody who lies goes to the front or a side, and that hips then move over feet at rest."""

STANDING, LYING, FLOORS = (-0.15, 0.15), (-0.03, 0.25), (-1.6, 1.6)
"""Heights of the lowest joint, leg lengths: on a ground at 0, and on any that people lie on."""

ABOVE = 0.01
"""A body that also stands on a ground at 0 lies on another if it is all above it by this."""

ACROSS = 0.06
"""A body that reaches further below height 0, in leg lengths, and above it or nearly, lies on no ground."""

FIXED, NEAR = 1e-3, 0.3
"""A joint that moves by fewer leg lengths, and is so near the hips, is the origin: no ground is seen."""


class Kind(NamedTuple):
    """A kind of files; one axis is up in all of a library's files of a kind, or of one skeleton of it."""

    name: str
    usual: Up  # by the format's convention, or by the file's rest pose
    firm: bool = False  # whether the convention is the format's own
    told: bool = False  # whether the rest pose says it, or the program that wrote the file
    read: tuple[Up, ...] = ("y", "z")  # axes that are believed without being given
    skeleton: str = ""

    @property
    def own(self) -> str:
        """The name of its skeleton's files."""
        return f"{self.name} {self.skeleton}".rstrip()

    @property
    def likely(self) -> list[int]:
        """The numbers of the axes that are up in most files."""
        return [axis for axis, up in enumerate(UPS) if up in ("y", "z", self.usual)]


@dataclass(frozen=True, eq=False)
class Sight:
    """How a clip looks along the six axes of `UPS`; lengths are in lengths of its legs."""

    upright: np.ndarray  # (6,) share of the frames in which the body is upright
    poised: np.ndarray  # (6,) whether the body is over its feet in most frames, as nobody is who sits
    lowest: np.ndarray  # (6,) height of the lowest joint above the origin, median
    steady: np.ndarray  # (6,) whether that stays what it is, but for stairs
    floats: np.ndarray  # (6,) whether it goes up and down further than a body on a ground does
    moves: np.ndarray  # (6,) whether, while it is upright, it moves as nobody does who lies
    placed: bool  # whether positions are in a world, and not from the hips

    @classmethod
    def of_body(cls, joints: np.ndarray, columns: Mapping[int, int] | range) -> Self:
        """Look at joints (T, J, 3) of a body, given the column of each joint of `JOINT_NAMES`."""
        sides = {
            part: [columns[JOINT_INDEX[f"{side}_{part}"]] for side in ("left", "right")] for part in LIMBS
        }
        return cls.of(joints, {part: joints[:, both] for part, both in sides.items()})

    @classmethod
    def of(cls, joints: np.ndarray, limbs: Mapping[str, np.ndarray]) -> Self:
        """Look at joints (T, J, 3) and the left and right one of each of `LIMBS` (T, 2, 3).

        NaN marks what was not seen. Raises ValueError if hips and shoulders are never seen together.
        """
        trunk = unit((limbs["shoulder"] - limbs["hip"]).mean(axis=1))
        if not (seen := np.isfinite(trunk).all(axis=1)).any():
            raise ValueError(
                "its hips and shoulders are never seen together: nobody is in it, or its joints are in "
                "another order (--pose-joints)"
            )
        joints, trunk = joints[seen], trunk[seen]
        hips, knees, ankles, shoulders = (limbs[part][seen] for part in LIMBS)  # (T, 2, 3)
        from_feet = [unit((above - ankles).mean(axis=1)) for above in (shoulders, (hips + shoulders) / 2)]
        upright, poised = (
            (np.where(np.isfinite(line), line, trunk) @ AXES.T > least).T  # (6, T)
            for line, least in zip(from_feet, (UPRIGHT, POISED), strict=True)
        )
        bones = [np.linalg.norm(bone, axis=-1) for bone in (hips - knees, knees - ankles)]
        known = [bone[np.isfinite(bone)] for bone in bones]
        legs = sum(np.median(bone) if len(bone) else np.inf for bone in known) or np.inf
        each = np.ascontiguousarray(joints.swapaxes(0, 1))  # five times as fast
        heights = np.concatenate([np.fmin.reduce(each), -np.fmax.reduce(each)], axis=1) / legs  # (T, 6)
        low, high = np.percentile(heights, (10, 90), axis=0)
        left = np.diff((hips + shoulders)[:, ::-1], axis=1)[:, 0]
        ahead = np.cross(left, trunk)
        ahead = unit(ahead - (ahead @ AXES.T).T[..., None] * AXES[:, None])  # (6, T, 3)
        faces = np.stack([ahead, np.cross(AXES[:, None], ahead)])  # ahead and aside
        step = np.diff(hips.mean(axis=1), axis=0) / legs
        along = np.sum((faces[:, :, 1:] + faces[:, :, :-1]) / 2 * step, axis=-1)  # (2, 6, T - 1)
        gone = np.linalg.norm(np.nansum(along * (upright[:, 1:] & upright[:, :-1]), axis=-1), axis=0)
        rise = high - low
        steady = (rise <= np.maximum(STEADY, STEEP * gone)) | (rise > MISTAKEN)
        middle = hips.mean(axis=1, keepdims=True)
        about = np.concatenate([joints - middle, 0 * middle], axis=1)
        near = np.mean(np.einsum("tja,tja->tj", about, about) < (NEAR * legs) ** 2, axis=0) > MOSTLY
        spread = np.ptp((about + middle)[:, near], axis=0)
        over = middle[:, 0] @ AXES.T / legs
        bent = [np.ptp(np.percentile(each, (5, 95), axis=0), axis=0) for each in (over, over - heights)]
        return cls(
            upright.mean(axis=1),
            poised.mean(axis=1) >= MOSTLY,
            np.median(heights, axis=0),
            steady,
            ~steady & ((rise > LEAPS) | (upright.mean(axis=1) < MOSTLY)),
            (gone >= WALKS) | (np.min(bent, axis=0) >= BENDS),
            bool(np.nanmin(spread.max(axis=1)) > FIXED * legs),
        )

    def by_itself(self, kind: Kind) -> Up | None:
        """The axis that is up in one file of this kind, believed or not; None if it is to be asked for."""
        sure = self.sure(kind)
        if not any(self.moves[axis] for axis in sure):
            if kind.told:
                return UPS[sure[0]] if len(sure) == 1 and self.poised[sure[0]] else kind.usual
            if kind.firm and not sure and not self._contradicts(kind):
                return kind.usual
        return UPS[sure[0]] if len(sure) == 1 else None

    def sure(self, kind: Kind) -> list[int]:
        """Axes along which the body stands beyond doubt: it moves as nobody does who lies, or cannot lie."""
        stands, usual = self.stands(kind), UPS.index(kind.usual)
        return [axis for axis in stands if self.moves[axis]] or [
            axis
            for axis in stands
            if axis in kind.likely
            and self._cannot_lie(axis, kind)
            and (self._at(axis, STANDING) or (axis == usual and self.poised[axis]))
        ]

    def _contradicts(self, kind: Kind) -> bool:
        """Whether the body may stand, hang, or lie on a ground at 0, along another axis than the format's."""
        usual = UPS.index(kind.usual)
        others = [axis for axis in kind.likely if axis != usual]
        lies = self.lies(usual)
        on_feet = self.upright[usual] >= MOSTLY and self._at(usual, STANDING)
        return (
            bool(self.floats[usual] or self.upright[usual - 3] >= MOSTLY)
            or any(self.lies(axis, ABOVE if on_feet else LYING[0]) for axis in others)
            or any(self.may_stand(axis) and (self.steady[axis] or not lies) for axis in others)
            or any(self.may_stand(axis - 3) and not lies for axis in others)
        )

    def lies(self, axis: int, least: float = LYING[0]) -> bool:
        """Whether the body may lie on a ground at 0, with its lowest joint no lower than `least`."""
        return bool(self.steady[axis] and self._at(axis, (least, LYING[1])))

    def may_stand(self, axis: int) -> bool:
        """Whether the body is upright along an axis, and does not just sit away from a ground at 0."""
        grounded = self.poised[axis] or not self.placed or self._at(axis, STANDING)
        return bool(self.upright[axis] >= THROUGHOUT and grounded)

    def votes(self, kind: Kind) -> list[Up]:
        """The axes that the file speaks for as one of many of this kind."""
        stands = self.stands(kind)
        if kind.told or any(self.moves[axis] for axis in stands):
            return [up for up in [self.by_itself(kind)] if up]
        return [UPS[axis] for axis in stands if self._cannot_lie(axis, kind)]

    def stands(self, kind: Kind) -> list[int]:
        """Axes along which the body is upright over a steady ground."""
        found = np.flatnonzero((self.upright >= THROUGHOUT) & self.steady)
        upright = (UPS.index(kind.usual), 0, 1, 2)  # along others it may be on its hands
        return [axis for axis in found if axis in upright or self._at(axis, STANDING)]

    def _cannot_lie(self, axis: int, kind: Kind) -> bool:
        """Whether none of the other axes can be up, with the body on some ground."""
        return not any(
            self._at(other, FLOORS)
            and not (self.placed and self.lowest[other] < -ACROSS and self.lowest[other - 3] < ACROSS)
            for other in kind.likely
            if other % 3 != axis % 3
        )

    def _at(self, axis: int, heights: tuple[float, float]) -> bool:
        return bool(heights[0] <= self.lowest[axis] <= heights[1])
