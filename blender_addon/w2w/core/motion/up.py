# SPDX-License-Identifier: GPL-3.0-or-later
"""The axis that is up in a motion file whose format lacks it: by a rest pose, or a vote of its library."""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from ..wording import count
from .sight import MOSTLY, UPS, Kind, Sight, Up
from .source import UnusableMotion

SURE, SEVERAL = 2, 3
"""Clips beyond doubt, and clips in all, by which an axis must lead in a vote."""

HEAD_DOWN = -0.5
"""A trunk points down if its own up has less than this along the world's."""

SAY_UP = "give --pose-up, or Up in Blender's import dialog"

UPSIDE_DOWN = f"trunks point down in most of the frames: {SAY_UP}, with the axis of the file that is up"


@dataclass(frozen=True)
class Ups:
    """The axis that is up in a library's files of a kind; None where it is to be asked for.

    Files of other kinds speak for themselves.
    """

    chosen: tuple[tuple[str, Up | None], ...] = ()

    def of(self, kind: Kind, seen: Sight) -> Up:
        """The axis that is up in a file; UnusableMotion if the user must give it."""
        up = self.found(kind, seen)
        if up is None:
            raise UnusableMotion(f"it does not say which axis is up; {_shown([seen])}")
        if up not in kind.read:
            raise UnusableMotion(f"its person stands along {up} of its axes: {SAY_UP}, if that is up")
        return up

    def with_guess(self, kind: Kind, look: Callable[[], Sight]) -> tuple[Up, str]:
        """What `of` and `guess` give, without a look at the file where all of its skeleton share an axis."""
        if (up := dict(self.chosen).get(kind.own)) in kind.read:
            return up, "" if up == kind.usual and (kind.told or kind.firm) else up
        up = self.of(kind, seen := look())
        return up, self.guess(kind, seen, up)

    def found(self, kind: Kind, seen: Sight) -> Up | None:
        """The axis that is up in a file, by its skeleton's files, its own rest pose or its kind's files."""
        chosen = dict(self.chosen)
        if up := chosen.get(kind.own):
            return up
        return seen.by_itself(kind) if kind.told or kind.name not in chosen else chosen[kind.name]

    def guess(self, kind: Kind, seen: Sight, up: Up) -> str:
        """The axis, if neither a rest pose nor people who stand say it by a format's convention; else ""."""
        several = {kind.name, kind.own} & dict(self.chosen).keys()
        said = kind.told or (kind.firm and (several or UPS.index(up) in seen.sure(kind)))
        return "" if said and up == kind.usual else up


BY_ITSELF = Ups()
"""The `Ups` for a file that is part of no library."""


class Unasked(Ups):
    """Axes for a look at a file before its library is known: where one would be asked for, the usual one."""

    def of(self, kind: Kind, seen: Sight) -> Up:
        """The axis that a file is looked at with."""
        up = self.found(kind, seen)
        return up if up is not None and up in kind.read else kind.usual


@dataclass(frozen=True)
class Votes(Ups):
    """Votes of a library's files on the axis that is up: read each file with it, then ask for the `ups`."""

    cast: list[tuple[Kind, Sight]] = field(default_factory=list)
    others: list[str] = field(default_factory=list)  # files whose format says the axis

    def of(self, kind: Kind, seen: Sight) -> Up:
        """Take down how a file looks."""
        self.cast.append((kind, seen))
        return kind.usual

    @cached_property
    def ups(self) -> Ups:
        """One axis for all files of a kind, or of a skeleton."""
        groups = defaultdict(list)
        for kind, seen in self.cast:
            for name in {kind.own, kind.name}:
                groups[name].append((kind, seen))
        kinds = {kind.name for kind, _ in self.cast}
        axes = {name: _axis(group) for name, group in sorted(groups.items()) if len(group) > 1}
        return Ups(tuple((name, up) for name, up in axes.items() if up or name in kinds))

    def sentence(self) -> str:
        """The axes, their files and why, such as "z, 40 files of AMASS"; "" without files."""
        ups, parts = self.ups, Counter[tuple[str, str, str]]()
        for kind, seen in self.cast:
            up = ups.found(kind, seen)
            why = ", as people stand" if up != kind.usual or not kind.firm else ", as is usual"
            parts[kind.name, up or "not known", why if up and ups.guess(kind, seen, up) else ""] += 1
        return "; ".join(
            f"{up}, {count('file', n)} of {name}{why}" for (name, up, why), n in sorted(parts.items())
        )

    @property
    def question(self) -> str:
        """What the user must say before most of the library can be read; "" if nothing."""
        ups = self.ups
        asked = [(kind, seen) for kind, seen in self.cast if ups.found(kind, seen) not in kind.read]
        if not asked or 2 * len(asked) < len(self.cast) + len(self.others):
            return ""
        what = f"{count('file', len(asked))} of {', '.join(sorted({kind.name for kind, _ in asked}))}"
        return f"nothing says which axis is up in {what}; {_shown([seen for _, seen in asked])}"


def _axis(group: Sequence[tuple[Kind, Sight]]) -> Up | None:
    """One axis for all files of a group; None if nothing decides, or most people would lie or hang."""
    votes = Counter(up for kind, seen in group for up in seen.votes(kind))
    (best, first), (_, second) = [*votes.most_common(2), (None, 0), (None, 0)][:2]
    alone = Counter(seen.by_itself(kind) for kind, seen in group)
    usual = {kind.usual if kind.firm else None for kind, _ in group}
    by_format = usual.pop() if len(usual) == 1 else None
    up = next(iter(alone)) if len(alone) == 1 else None
    if by_format and not {*votes} - {by_format} and (votes or 2 * alone[by_format] > len(group)):
        up = by_format
    elif best and first - second >= SURE:
        standing = sum(UPS.index(best) in seen.stands(kind) for kind, seen in group)
        up = best if max(first, standing) - second >= SEVERAL else up
    elif by_format and not votes:
        up = _stood_along([seen for _, seen in group], group[0][0])
    if up is None or any(kind.told for kind, _ in group):
        return up
    number = UPS.index(up)
    upright, hang = (sum(seen.upright[axis] >= MOSTLY for _, seen in group) for axis in (number, number - 3))
    return up if 2 * upright >= len(group) or (up == by_format and 2 * hang <= len(group)) else None


def _stood_along(sights: Sequence[Sight], kind: Kind) -> Up | None:
    """The axis along which several people may stand, who neither stand nor lie along the format's."""
    usual = UPS.index(kind.usual)
    rest = [
        seen for seen in sights if not (seen.placed and seen.lies(usual)) and seen.upright[usual] < MOSTLY
    ]
    for axis in kind.likely:
        standing = sum(bool(seen.may_stand(axis) and seen.steady[axis]) for seen in rest)
        if axis != usual and standing - (len(sights) - len(rest)) >= SEVERAL and 2 * standing > len(sights):
            return UPS[axis]
    return None


def _shown(sights: Sequence[Sight]) -> str:
    """Along which axes people may stand, in words."""
    axes = [UPS[int(seen.upright.argmax())] if seen.upright.max() >= MOSTLY else "none" for seen in sights]
    files = sorted(Counter(axes).items(), key=lambda each: (each[0] == "none", -each[1], each[0]))
    shown = axes[0] if len(axes) == 1 else ", ".join(f"{axis} in {number}" for axis, number in files)
    return f"people may stand along {shown}: {SAY_UP}"


def mostly_head_down(motions: Iterable[tuple[int, bool]]) -> bool:
    """Whether most frames are of motions head down, by each motion's frames and whether it is."""
    frames = list(motions)
    return 2 * sum(count for count, down in frames if down) > sum(count for count, _ in frames)
