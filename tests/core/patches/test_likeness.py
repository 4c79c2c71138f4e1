# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape of our body that has a character's proportions."""

import pytest

from w2w.core.body.shapes import shaped
from w2w.core.patches.correspondence import likeness

from .test_correspondence import character


@pytest.mark.parametrize("unit", [1.0, 100.0])
def test_the_shape_that_a_character_was_made_with_is_found(bundled_body, unit):
    made = {"arms": 1.1, "legs": 0.92, "height": 1.6}
    found = likeness(character(shaped(bundled_body, **made), unit=unit), bundled_body)
    assert found == pytest.approx(made, abs=0.03)


def test_what_no_person_is_stays_within_the_shapes_there_are(bundled_body):
    figure = character(bundled_body, unit=0.02)
    assert set(likeness(figure, bundled_body)) == {"arms", "legs"}
