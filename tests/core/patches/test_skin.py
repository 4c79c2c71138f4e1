# SPDX-License-Identifier: GPL-3.0-or-later
"""Distances over the skin: symmetric, true on a flat sheet, and to mirror images across the body."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.patches.patches import sample_patches
from w2w.core.patches.strip_graph import SkinDistances

pytestmark = pytest.mark.later


@pytest.fixture(scope="module")
def measured():
    body = Body.bundled()
    half = sample_patches(body, 48).vertices
    vertices = np.unique([half, body.mirror[half]])
    return body, vertices, SkinDistances.of(body, vertices)


def test_between_patches_is_symmetric_and_never_shorter_than_the_straight_line(measured):
    body, vertices, skin = measured
    place = body.vertices[vertices]
    straight = np.linalg.norm(place[:, None] - place, axis=2)
    np.testing.assert_allclose(skin.between, skin.between.T, atol=1e-9)
    assert (skin.between >= straight - 1e-9).all()
    np.testing.assert_array_equal(np.diag(skin.between), 0)


def test_where_all_come_in_pairs_every_mirror_image_is_a_patch(measured):
    body, vertices, skin = measured
    np.testing.assert_allclose(skin.to_mirror_image.min(axis=1), 0, atol=1e-9)
    nearest = skin.to_mirror_image.argmin(axis=1)
    np.testing.assert_array_equal(vertices[nearest], body.mirror[vertices])


def test_a_body_without_a_mirror_map_is_reflected(measured):
    body, vertices, skin = measured
    found = SkinDistances.of(replace(body, mirror=None), vertices)
    np.testing.assert_allclose(found.to_mirror_image, skin.to_mirror_image, atol=0.02)
