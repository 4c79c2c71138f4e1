# SPDX-License-Identifier: GPL-3.0-or-later
"""What people wear, by its everyday name: where the sensor in it sits, and where else it may."""

from __future__ import annotations

from typing import NamedTuple


class Product(NamedTuple):
    """A wearable product.

    Attributes
    ----------
    region : str
        Region where its sensor usually sits; "*" stands for left or right.
    reach : tuple of str
        Regions that it touches, without their side: what wishes such as "only belt" mean.
    """

    region: str
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
