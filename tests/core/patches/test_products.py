# SPDX-License-Identifier: GPL-3.0-or-later
"""Everyday products are understood wherever words for spots on the body are."""

import numpy as np
import pytest

from w2w.core.body.regions import regions_of
from w2w.core.patches.body_parts import ALL, PRODUCTS, find_patches
from w2w.core.patches.naming import place


def test_products_are_made_of_regions_that_a_body_has(bundled_body):
    names = set(regions_of(bundled_body)[1])
    for product in PRODUCTS.values():
        assert set(product.reach) <= set(ALL)
        assert product.region.replace("*", "left") in names
        assert product.region.removeprefix("* ") in product.reach


@pytest.mark.parametrize("name", PRODUCTS)
def test_a_product_is_one_place_to_wear_and_all_patches_it_touches_to_wish_for(name, bundled_body, patches):
    codes, names = regions_of(bundled_body)
    region = names[codes[place(name, bundled_body)]]
    assert region.removeprefix("left ") in PRODUCTS[name].reach
    touched = find_patches(patches.regions, patches.names, name)
    sides = [find_patches(patches.regions, patches.names, f"{side} {name}") for side in ("left", "right")]
    assert set(np.concatenate(sides)) <= set(touched)
    assert all(patches.regions[patch].startswith("right ") for patch in sides[1])


def test_the_other_side_is_asked_for_by_name(bundled_body):
    codes, names = regions_of(bundled_body)
    assert names[codes[place("right watch", bundled_body)]] == "right wrist dorsal"
    assert names[codes[place("right phone in pocket", bundled_body)]] == "right front pocket"
    with pytest.raises(ValueError, match="did you mean"):
        place("wach", bundled_body)


def test_a_finger_is_still_one_finger(patches):
    rings = find_patches(patches.regions, patches.names, "left ring finger")
    assert {patches.regions[patch] for patch in rings} == {"left ring finger"}
