# SPDX-License-Identifier: GPL-3.0-or-later
"""What people wear and where: the placements of the field, and products by their everyday names.

The eight common placements are our reading of what the field uses (watch, armband, chest strap, belt clip,
trouser pocket, ankle band, shoe, earbud); the three unusual ones are those the paper found strong though
seldom used.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True)
class Placement:
    """A place to wear a sensor."""

    name: str  # what it is called: "wrist"
    region: str  # at whose centre it lies; "*" is for left or right
    common: bool  # whether wearables are usually worn there

    @property
    def sided(self) -> bool:
        """Whether it exists on the left and on the right."""
        return "*" in self.region

    def on(self, side: str) -> str:
        """Name of the region on one side."""
        return self.region.replace("*", side)


PLACEMENTS: tuple[Placement, ...] = (
    Placement("wrist", "* wrist dorsal", common=True),
    Placement("upper arm", "* upper arm lateral", common=True),
    Placement("chest", "sternum", common=True),
    Placement("waist", "* hip", common=True),
    Placement("pocket", "* front pocket", common=True),
    Placement("ankle", "* ankle lateral", common=True),
    Placement("foot", "* instep", common=True),
    Placement("ear", "* ear", common=True),
    Placement("posterior scapula", "* posterior scapula", common=False),
    Placement("lower spine", "lower spine", common=False),
    Placement("lateral oblique", "* lateral oblique", common=False),
)
"""The 11 placements: 8 common ones and 3 unusual ones."""


class Product(NamedTuple):
    """A wearable product."""

    region: str  # where its sensor usually sits; "*" is for left or right
    # regions that it touches, without their side: what wishes such as "only belt" mean
    reach: tuple[str, ...]


WRIST = ("wrist dorsal", "wrist thumb side", "wrist little finger side", "wrist volar")
FINGERS = ("index finger", "middle finger", "ring finger", "little finger")
RIBS = ("sternum", "chest", "front ribs", "side ribs", "middle back", "middle spine")

PRODUCTS: dict[str, Product] = {
    "watch": Product("* wrist dorsal", WRIST),
    "ring": Product("* ring finger", FINGERS),
    "earbud": Product("* ear", ("ear",)),
    "glasses": Product("* temple", ("temple", "behind ear", "nose")),
    "headband": Product("forehead", ("forehead", "temple", "side of head", "back of head")),
    "chest strap": Product("sternum", RIBS),
    "belt": Product("* hip", ("hip", "front hip", "lower abdomen", "lower back", "lower spine")),
    "phone in pocket": Product("* front pocket", ("front pocket",)),
    "knee brace": Product("* knee lateral", ("knee lateral", "knee front", "knee medial", "knee back")),
    "shoe": Product("* instep", ("instep", "toes", "heel", "sole", "foot lateral", "foot medial")),
}
"""Our reading of where such products are worn."""
