# SPDX-License-Identifier: GPL-3.0-or-later
"""Everyday words find the places that a designer means by them."""

import numpy as np
import pytest

from w2w.core.body.regions import regions_of
from w2w.core.patches.body_parts import PARTS, find_patches, is_understood, suggestions


def found(patches, wish):
    return set(find_patches(patches.regions, patches.names, wish).tolist())


def test_every_region_belongs_to_one_of_the_five_great_parts(bundled_body):
    stems = {name.removeprefix("left ").removeprefix("right ") for name in regions_of(bundled_body)[1]}
    listed = [stem for part in ("head", "neck", "torso", "arm", "leg") for stem in PARTS[part]]
    assert sorted(listed) == sorted(stems)


def test_great_parts_share_the_body_out(patches):
    parts = [found(patches, part) for part in ("head", "neck", "torso", "arm", "leg")]
    assert sum(len(part) for part in parts) == len(patches)
    assert set.union(*parts) == set(range(len(patches)))


def test_sides_and_middle_share_the_body_out(patches):
    left, right, middle = (found(patches, side) for side in ("left", "right", "middle"))
    assert len(left) + len(right) + len(middle) == len(patches)
    assert left | right | middle == set(range(len(patches)))
    assert {patches.regions[place] for place in middle} <= {
        region for region in patches.regions if not region.startswith(("left", "right"))
    }


def test_a_part_lies_where_its_joints_are(patches, bundled_body):
    positions = bundled_body.vertices[patches.vertices]
    elbow, neck, crotch = (bundled_body.joints[joint] for joint in (18, 12, 0))
    assert (positions[list(found(patches, "head")), 2] > neck[2]).all()
    assert (positions[list(found(patches, "leg")), 2] < crotch[2] + 0.05).all()
    assert (np.abs(positions[list(found(patches, "hand")), 0]) > abs(elbow[0])).all()
    assert found(patches, "hand") < found(patches, "arm")
    assert found(patches, "foot") < found(patches, "leg")
    assert found(patches, "back") | found(patches, "chest") < found(patches, "torso")


def test_words_sides_names_and_placements(patches):
    regions = patches.regions
    assert {regions[place] for place in found(patches, "Left  Wrist")} <= {
        f"left wrist {side}" for side in ("dorsal", "volar", "thumb side", "little finger side")
    }
    assert found(patches, "left arm") == found(patches, "arm") & found(patches, "left")
    assert {regions[place] for place in found(patches, "waist")} == {"left hip", "right hip"}
    assert {regions[place] for place in found(patches, "right waist")} == {"right hip"}
    assert found(patches, patches.names[77]) >= {77}
    assert len(found(patches, "sternum 02")) == 1
    with pytest.raises(ValueError, match=r"^no patch is called 'rigth arm'; did you mean right arm\?$"):
        find_patches(patches.regions, patches.names, "rigth arm")
    with pytest.raises(ValueError, match=r"no patch is called 'tail': write a part of the body \(left"):
        found(patches, "tail")


OFFERED = (("left wrist", "sternum"), ("left wrist", "my ring"))
"""Regions and names of two patches."""


def test_names_are_offered_for_what_is_typed():
    assert suggestions(*OFFERED, "")[:3] == ["left", "right", "middle"]
    assert suggestions(*OFFERED, "Left wri") == ["left wrist"]
    assert {"left leg", "right leg"} <= set(suggestions(*OFFERED, "leg"))
    assert suggestions(*OFFERED, "ring")[-1] == "my ring"


def test_every_name_that_is_offered_is_understood(patches):
    known = patches.regions, patches.names
    assert [name for name in suggestions(*known, "") if not is_understood(*known, name)] == []
    assert is_understood(*OFFERED, "left wrist, belt")
    assert not is_understood(*OFFERED, "left wrist, tail")
