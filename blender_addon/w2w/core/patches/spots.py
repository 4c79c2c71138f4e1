# SPDX-License-Identifier: GPL-3.0-or-later
"""A spot in a segment's per cents: as words, as a short string and back, and on a body's skin."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from ..body.body import Body
from ..wording import plain_words
from .body_parts import side_of
from .tape_segments import MIDDLE, SEGMENT_NAMES, SEGMENTS, Segment, segments_of

LEAST, MOST = -100.0, 250.0
"""Per cents along that a spot may have: the skin of a segment goes on beyond its landmarks."""

_NUMBER = r"(?<![\d.])[-+]?(?:\d+(?:\.\d*)?|\.\d+)"
_NOTATION = re.compile(rf"(?P<segment>.*?)\s*(?P<along>{_NUMBER})\s*%\s*(?P<around>{_NUMBER})\s*%")


@dataclass(frozen=True)
class Spot:
    """A place on the skin: `left forearm 85% 50%`, as a string.

    `core.patches.tape_segments` explains the per cents.
    """

    segment: str  # one of SEGMENT_NAMES
    along: float  # per cent from the proximal landmark to the distal one
    around: float  # per cent of the circumference, from the front over the outer (or left) side; 0 to 100

    def __str__(self) -> str:
        return f"{self.segment} {_short(self.along)}% {_short(self.around % 100)}%"

    @classmethod
    def parse(cls, text: str) -> Spot:
        """Read what `str` writes.

        Raises ValueError, with what to write instead, if it is no segment and two per cents.
        """
        match = _NOTATION.fullmatch(plain_words(text))
        if match is None:
            raise ValueError(
                f"'{text}' is no spot: write a segment, the per cent along it and the per cent around it, "
                "such as 'left forearm 85% 50%'"
            )
        segment = _segment_called(match["segment"])
        along, around = float(match["along"]), float(match["around"])
        if not LEAST <= along <= MOST:
            given = SEGMENTS[side_of(segment)[1]]
            raise ValueError(
                f"'{text}' lies {along:g} % along the {segment}: 0 is {given['from']} and 100 {given['to']}, "
                f"and {LEAST:g} to {MOST:g} are allowed"
            )
        if not 0 <= around <= 100:
            raise ValueError(f"'{text}' lies {around:g} % around the {segment}: that is from 0 to 100 %")
        return cls(segment, along, around)

    def in_words(self) -> str:
        """Instructions for a person with a tape.

        Examples
        --------
        >>> Spot("left forearm", 85, 50).in_words()
        'left forearm, 85 % of the way from elbow crease to wrist crease, back of the arm'
        """
        given = SEGMENTS[side_of(self.segment)[1]]
        start, end = given["from"], given["to"]
        if self.along < 0:
            way = f"{-self.along:.0f} % of the way from {start} to {end}, but beyond {start}"
        elif self.along > 100:
            way = f"{self.along - 100:.0f} % of the way from {start} to {end} beyond {end}"
        else:
            way = f"{self.along:.0f} % of the way from {start} to {end}"
        return f"{self.segment}, {way}, {side_in_words(given, self.around)}"


def side_in_words(given: dict[str, object], around: float) -> str:
    """The side of a segment, or the two between which a per cent around lies."""
    eighth = round(around / 12.5) % 8
    sides: list[str] = given["sides"]  # type: ignore[assignment]
    first = sides[eighth // 2]
    if eighth % 2:
        return f"between {first} and {sides[(eighth // 2 + 1) % 4]}"
    return first if "side" in first or first in ("palm", "sole") else f"{first} of the {given['called']}"


def locate(body: Body, vertex: int) -> Spot:
    """The spot that a vertex of a body's skin is at."""
    name, segment = next((n, s) for n, s in segments_of(body).items() if vertex in s.vertices)
    along, around = (float(value[0]) for value in segment.coordinates(body.vertices[vertex][None]))
    return Spot(name, along, around)


def vertex_at(body: Body, spot: Spot) -> int:
    """The vertex of a body nearest to a spot: the inverse of `locate`.

    Raises ValueError if the segment has no skin within a tenth of its length of the spot.
    """
    segment = segments_of(body)[spot.segment]
    away = np.linalg.norm(_aside(segment, body.vertices[segment.vertices], spot), axis=1)
    if away.min() > 0.1 * segment.length:
        raise ValueError(f"{spot} is not on this body: the {spot.segment} has no skin there")
    return int(segment.vertices[away.argmin()])


def _aside(segment: Segment, points: np.ndarray, spot: Spot) -> np.ndarray:
    """Distances of points (P, 3) from a spot along and around the segment, metres, shape (P, 2)."""
    along, around = segment.coordinates(points)
    turned = (around - spot.around + 50) % 100 - 50
    return np.stack(
        [(along - spot.along) / 100 * segment.length, turned / 100 * segment.girth(spot.along)], axis=1
    )


def _short(value: float) -> str:
    return f"{round(value, 1) + 0.0:g}"


def _segment_called(words: str) -> str:
    if words in SEGMENT_NAMES:
        return words
    if words in SEGMENTS and words not in MIDDLE:
        raise ValueError(f"say which {words} is meant: 'left {words}' or 'right {words}'")
    close = get_close_matches(words, SEGMENT_NAMES, n=3, cutoff=0.5)
    hint = f"did you mean {', '.join(close)}?" if close else f"there are {', '.join(SEGMENT_NAMES)}"
    raise ValueError(f"no segment is called '{words}': {hint}")
