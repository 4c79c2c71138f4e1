# SPDX-License-Identifier: GPL-3.0-or-later
"""The axis that is up in a motion file whose format lacks it, by how people stand and lie in it."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple, Self

import numpy as np

from ..rotations import smallest_rotation, unit
from ..wording import count
from .source import SourceMotion, UnusableMotion

Up = Literal["x", "y", "z", "-x", "-y", "-z"]

UPS: tuple[Up, ...] = ("x", "y", "z", "-x", "-y", "-z")

_AXES = np.concatenate([np.eye(3), -np.eye(3)])

TO_Z = dict(zip(UPS, smallest_rotation(_AXES, np.array([0.0, 0.0, 1.0])).round() + 0.0, strict=True))
"""Rotations that turn an axis to z."""

LIMBS = ("hip", "knee", "ankle", "shoulder")
"""Joints of both sides that show how a body stands."""

UPRIGHT = np.cos(np.radians(45))
"""A body is upright along an axis if the line from its feet to its shoulders leans from it by less."""

MOSTLY, OFTEN = 0.5, 0.2
"""Shares of the frames that decide how a clip is, and that it is so at times."""

CLEARLY = 1.2
"""How many times as far the head goes over its ground along one axis as along any other that is so plain."""

STEADY = 0.35
"""The lowest joint of someone on the ground rises and falls by less, in leg lengths."""

AT_GROUND = 0.15
"""The lowest joint of someone who stands is this near to height 0, in leg lengths."""

LYING = (0.01, 0.25)
"""Height of the lowest joint of someone who lies on a ground at 0, in leg lengths."""

HIP_HEIGHT = (0.6, 1.3)
"""Height of the hips above the lowest joint of a standing body, in leg lengths."""

MOVES = 0.05
"""Hips that move by fewer leg lengths are the origin."""

RISE, SLIDE = 0.8, 2.0
"""Leg lengths that nobody rises by, or moves sideways, while lying in one direction."""

HEAD_DOWN = -0.5
"""A trunk points down if its own up has less than this along the world's."""

SAY_UP = "give --pose-up, or Up in Blender's import dialog"

UPSIDE_DOWN = f"trunks point down in most of the frames: {SAY_UP}, with the axis of the file that is up"


class Kind(NamedTuple):
    """A kind of files; one axis is up in all of a library's files of a kind."""

    name: str
    usual: Up  # the format's own convention
    firm: bool = True  # whether only plain signs speak against the usual axis
    read: tuple[Up, ...] = ("y", "z")  # axes that are believed without being given


@dataclass(frozen=True, eq=False)
class Sight:
    """How a clip looks along the six axes of `UPS`; lengths are in lengths of its legs."""

    upright: np.ndarray  # (6,) share of the frames in which the body is upright
    lowest: np.ndarray  # (6,) height of the lowest joint above the origin, median
    steady: np.ndarray  # (6,) range of that
    hips: np.ndarray  # (6,) height of the hips above the lowest joint, median
    travel: np.ndarray  # (6, 3) range of the hips along x, y and z while the body is upright along each
    along: Up  # the axis nearest to the trunk's mean direction
    frames: int  # in which hips and shoulders are seen

    @classmethod
    def of(cls, joints: np.ndarray, limbs: Mapping[str, np.ndarray]) -> Self:
        """Look at joints (T, J, 3) and the left and right one of each of `LIMBS` (T, 2, 3).

        NaN marks what was not seen. Raises ValueError if hips and shoulders are never seen together.
        """
        hips, shoulders, ankles = (limbs[part].mean(axis=1) for part in ("hip", "shoulder", "ankle"))
        trunk = unit(shoulders - hips)
        if not (seen := np.isfinite(trunk).all(axis=1)).any():
            raise ValueError(
                "its hips and shoulders are never seen together: nobody is in it, or its joints are in "
                "another order (--pose-joints)"
            )
        mean = trunk[seen].mean(axis=0)
        upwards = np.where(np.isfinite(ankles), unit(shoulders - ankles), trunk)[seen]
        upright = upwards @ _AXES.T > UPRIGHT  # (T, 6)
        ends = (("hip", "knee"), ("knee", "ankle"))
        bones = [np.linalg.norm(limbs[start] - limbs[end], axis=-1)[seen] for start, end in ends]
        known = [bone[np.isfinite(bone)] for bone in bones]
        legs = sum(np.median(bone) if len(bone) else np.inf for bone in known)
        place = hips[seen] / legs
        heights = np.nanmin(joints[seen] @ _AXES.T, axis=1) / legs  # (T, 6)
        low, high = np.percentile(heights, (10, 90), axis=0)
        placed = np.ptp(place, axis=0).max() > MOVES  # else positions are from the hips and show no ground
        inner = [np.percentile(place[rows], (5, 95), axis=0) for rows in upright.T if rows.any()]
        travel = np.zeros((6, 3))  # but for the farthest frames
        travel[upright.any(axis=0)] = np.ptp(np.reshape(inner, (-1, 2, 3)), axis=1)
        return cls(
            upright.mean(axis=0),
            np.median(heights, axis=0),
            placed * (high - low),
            np.median(place @ _AXES.T - heights, axis=0),
            travel,
            UPS[int((mean @ _AXES.T).argmax())],
            int(seen.sum()),
        )

    def up(self, kind: Kind) -> tuple[Up, bool]:
        """The axis that is up in a file of this kind by itself, and whether the clip shows it plainly."""
        usual = UPS.index(kind.usual)
        axes = [axis for axis in range(6) if UPS[axis] in kind.read or not kind.firm]
        if (ground := self._ground(axes)) is not None:
            return UPS[ground], True
        if self.upright[usual] >= MOSTLY:
            return kind.usual, True
        standing = [axis for axis in axes if self.upright[axis] >= MOSTLY and self._stands(axis)]
        if standing:
            best = max(standing, key=lambda axis: self.upright[axis])
            lying = [axis for axis in (usual, 1, 2) if self._lies(axis, best)]
            if self._plainly(best, usual) or not (kind.firm or lying):
                return UPS[best], True
            return (kind.usual if kind.firm else UPS[lying[0]]), False
        return (kind.usual if kind.firm or self.steady[usual] <= STEADY else self.along), False

    def _ground(self, believed: Sequence[int]) -> int | None:
        """The axis along which the head rises and falls over a steady ground, if a body lies down."""
        axes = [axis for axis in range(6) if self.upright[axis] >= OFTEN]
        rise = self.steady[np.arange(6) - 3] / np.maximum(self.steady, 0.01)
        over = {axis: rise[axis] for axis in axes if axis in believed}
        first, second = (*sorted(over.values(), reverse=True), 0.0, 0.0)[:2]
        if len({axis % 3 for axis in axes}) < 2 or first < CLEARLY * max(second, 2.0):
            return None
        best = max(over, key=over.__getitem__)
        return best if self.steady[best] <= STEADY else None

    def _stands(self, axis: int) -> bool:
        """Whether the ground stays where it is along an axis, or the body goes further across it: stairs."""
        across = np.delete(self.travel[axis], axis % 3)
        return bool(self.steady[axis] <= STEADY or self.steady[axis] < across.max())

    def _lies(self, axis: int, best: int) -> bool:
        """Whether the body may lie on a ground at 0 along an axis, and not stand on one along the `best`."""
        low, high = LYING
        at_ground = low <= self.lowest[axis] <= high and self.steady[axis] <= STEADY
        return bool(at_ground and axis % 3 != best % 3 and abs(self.lowest[best]) > AT_GROUND)

    def _plainly(self, best: int, usual: int) -> bool:
        """Whether the body stands along one axis so that it cannot lie with another up."""
        low, high = HIP_HEIGHT
        stands = abs(self.lowest[best]) <= AT_GROUND and low < self.hips[best] < high
        if stands and not LYING[0] <= self.lowest[usual] <= LYING[1]:
            return True
        aside = 3 - best % 3 - usual % 3
        travel = self.travel[best]
        return bool(best % 3 != usual % 3 and (travel[usual % 3] >= RISE or travel[aside] >= SLIDE))


@dataclass(frozen=True)
class Ups:
    """The axis that is up in a library's files of a kind; files of other kinds speak for themselves."""

    chosen: tuple[tuple[str, Up], ...] = ()

    def of(self, kind: Kind, seen: Sight) -> Up:
        """The axis that is up in a file; UnusableMotion if the user must give it."""
        up = dict(self.chosen).get(kind.name) or seen.up(kind)[0]
        if up not in kind.read:
            raise UnusableMotion(f"its person stands along {up} of its axes: {SAY_UP}, if that is up")
        return up


BY_ITSELF = Ups()
"""The `Ups` for a file that is part of no library."""


@dataclass(frozen=True)
class Votes(Ups):
    """Votes of a library's files on the axis that is up: read each file with it, then ask for the `ups`."""

    cast: dict[Kind, list[Sight]] = field(default_factory=lambda: defaultdict(list))
    others: list[str] = field(default_factory=list)  # files whose format says the axis

    def of(self, kind: Kind, seen: Sight) -> Up:
        """Take down how a file looks."""
        self.cast[kind].append(seen)
        return kind.usual

    @property
    def ups(self) -> Ups:
        """One axis for all files of a kind."""
        return Ups(tuple(sorted((kind.name, self._axis(kind)) for kind in self.cast)))

    def sentence(self) -> str:
        """The axes, their files and why, such as "z, 40 files of AMASS"; "" without files."""
        parts = []
        for kind, seen in sorted(self.cast.items()):
            up = self._axis(kind)
            how = "" if up == kind.usual else ", by their feet"
            parts.append(f"{up}, {count('file', len(seen))} of {kind.name}{how}")
        return "; ".join(parts)

    @property
    def head_down(self) -> bool:
        """Whether people hang head down in most frames of the files looked at, and there are no others."""
        down = [
            (sight.frames, bool(sight.upright[UPS.index(self._axis(kind)) - 3] >= MOSTLY))
            for kind, seen in self.cast.items()
            for sight in seen
        ]
        return not self.others and mostly_head_down(down)

    def _axis(self, kind: Kind) -> Up:
        seen = self.cast[kind]
        ups = [sight.up(kind) for sight in seen]
        votes = Counter(up for up, plain in ups if plain) or Counter(up for up, _ in ups)
        best = max(votes, key=lambda up: (votes[up], up == kind.usual, -UPS.index(up)))
        standing = sum(sight.upright[UPS.index(best)] >= MOSTLY for sight in seen)
        return kind.usual if kind.firm and 2 * max(standing, votes[best]) < len(seen) else best


def mostly_head_down(motions: Iterable[tuple[int, bool]]) -> bool:
    """Whether most frames are of motions head down, by each motion's frames and whether it is."""
    frames = list(motions)
    return 2 * sum(count for count, down in frames if down) > sum(count for count, _ in frames)


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
