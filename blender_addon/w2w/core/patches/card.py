# SPDX-License-Identifier: GPL-3.0-or-later
"""The tape-measure card of a sensor: where it goes, where its arrow points, how far it may slip and turn."""

from dataclasses import dataclass

import numpy as np

from ..body.body import Body
from ..wording import InShort, capital
from .body_parts import side_of
from .patches import PatchSet
from .spots import locate
from .strip_graph import StripGraph
from .tape_segments import SEGMENTS, segments_of


@dataclass(frozen=True, repr=False)
class Card(InShort):
    """Where one sensor goes, as a person finds it with a tape."""

    patch: int
    spot: str  # the notation that `Spot.parse` reads
    words: str
    arrow: str  # where the sensor's x axis points
    slip_cm: float | None  # how far it may slip before expected F1 falls by more than .02; None if not known
    turn_deg: int | None = None  # how far it may be turned about its normal till then; None if not known

    def in_short(self) -> str:
        """The whole card in sentences."""
        return self.in_words()

    def in_words(self) -> str:
        """The whole card in sentences."""
        given = {}
        if self.slip_cm is not None:
            more = " or more" if self.slip_cm >= FARTHEST_CM else ""
            given["slip"] = f"{self.slip_cm:.0f} cm{more}" if self.slip_cm else ""
        if self.turn_deg is not None:
            more = " or more" if self.turn_deg >= FARTHEST_DEG else ""
            given["turn"] = f"{self.turn_deg}°{more}" if self.turn_deg else ""
        may = " or ".join(f"{way} {far}" for way, far in given.items() if far)
        must_not = " or ".join(way for way, far in given.items() if not far)
        sentences = [
            capital(self.words),
            f"Arrow {self.arrow}" if self.arrow else "",
            f"May {may} before F1 falls by {DROP:.2f}".replace("0.", ".") if may else "",
            f"Must not {must_not}" if must_not else "",
        ]
        return " ".join(f"{sentence}." for sentence in sentences if sentence)


def make_card(body: Body | None, patches: PatchSet, expected: np.ndarray, patch: int) -> Card:
    """The card of a patch, with the expected F1 (N,) of all; its name alone without a body."""
    if body is None:
        return Card(patch, "", patches.names[patch], "", None)
    spot = locate(body, int(patches.vertices[patch]))
    arrow = arrow_in_words(body, patches, patch)
    return Card(patch, str(spot), spot.in_words(), arrow, slip_cm(body, patches, expected, patch))


STRAIGHT = 10.0
"""Degrees up to which an arrow counts as straight along or around a segment."""

DROP, FARTHEST_CM, FARTHEST_DEG = 0.02, 10.0, 90
"""Expected F1 that a slip or turn may cost, and the farthest ones that are tried."""


def arrow_in_words(body: Body, patches: PatchSet, patch: int) -> str:
    """Direction, in words, of the x axis of a patch's sensor on the body at rest.

    It is the frame of the patch's signals: x along v2 - v1 of its triangle, z outward.

    Examples: "along the forearm, towards the hand"; "along the thigh, towards the knee, turned 20° to the
    outer side"; "around the trunk, towards the left side".
    """
    spot = locate(body, int(patches.vertices[patch]))
    side, rest = side_of(spot.segment)
    given, segment = SEGMENTS[rest], segments_of(body)[spot.segment]
    called = rest if side else given["called"]
    v1, v2 = body.vertices[patches.triangles[patch, :2]]
    spoke = segment.axes @ (body.vertices[patches.vertices[patch]] - segment.origin)
    onward = np.array([0.0, -spoke[2], spoke[1]]) / np.hypot(spoke[1], spoke[2])  # as per cents around grow
    arrow = segment.axes @ (v2 - v1)
    ahead, round_it = arrow[0], arrow @ onward
    (near, far), sides = given["ends"], given["sides"]
    quarter = round(spot.around / 25)
    ways = {  # by quarter turns from straight ahead
        0: f"along the {called}, towards the {far}",
        1: f"around the {called}, towards the {sides[(quarter + 1) % 4]}",
        2: f"along the {called}, towards the {near}",
        3: f"around the {called}, towards the {sides[(quarter - 1) % 4]}",
    }
    turn = np.degrees(np.arctan2(round_it, ahead))
    nearest = round(turn / 90) % 4
    over = (turn - 90 * nearest + 180) % 360 - 180
    if abs(over) <= STRAIGHT:
        return ways[nearest]
    towards = ways[(nearest + (1 if over > 0 else -1)) % 4].split("towards the ")[1]
    return f"{ways[nearest]}, turned {abs(over):.0f}° to the {towards}"


def slip_cm(body: Body, patches: PatchSet, expected: np.ndarray, patch: int) -> float:
    """How far a sensor may slip over the skin, any way, before its expected F1 falls by more than .02.

    Grows a disc around the patch until it meets a patch whose expected F1 (N,) is lower by more, and returns
    the distance to the last good patch, 0 to 10 cm. Patches without an expected F1 (NaN) are skipped. The
    resolution is that of the patches: some 5 cm with 512.

    Raises ValueError if the patch itself has none.
    """
    if not np.isfinite(expected[patch]):
        raise ValueError(f"{patches.names[patch]} has no expected F1")
    graph = StripGraph.of(body.vertices, body.faces)
    away = 100 * graph.distances(int(patches.vertices[patch]), limit=FARTHEST_CM / 100)[patches.vertices]
    falls = expected < expected[patch] - DROP - 1e-9
    end = away[falls].min(initial=np.inf)
    if np.isinf(end):
        return FARTHEST_CM
    return float(away[(away < end) & np.isfinite(expected)].max())
