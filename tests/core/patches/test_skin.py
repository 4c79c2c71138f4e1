# SPDX-License-Identifier: GPL-3.0-or-later
"""Distances over the skin: symmetric, true on a flat sheet, and to mirror images across the body."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.patches.patches import sample_patches
from w2w.core.patches.strip_graph import SkinDistances


@pytest.fixture(scope="module")
def measured():
    body = Body.bundled()
    patches = sample_patches(body, 96, symmetric=True)
    return body, patches, SkinDistances.of(body, patches.vertices)


def test_between_patches_is_symmetric_and_never_shorter_than_the_straight_line(measured):
    body, patches, skin = measured
    place = body.vertices[patches.vertices]
    straight = np.linalg.norm(place[:, None] - place, axis=2)
    np.testing.assert_allclose(skin.between, skin.between.T, atol=1e-9)
    assert (skin.between >= straight - 1e-9).all()
    np.testing.assert_array_equal(np.diag(skin.between), 0)


def test_of_a_symmetric_sampling_every_mirror_image_is_a_patch(measured):
    body, patches, skin = measured
    np.testing.assert_allclose(skin.to_mirror_image.min(axis=1), 0, atol=1e-9)
    nearest = skin.to_mirror_image.argmin(axis=1)
    np.testing.assert_array_equal(patches.vertices[nearest], body.mirror[patches.vertices])


def test_a_body_without_a_mirror_map_is_reflected(measured):
    body, patches, skin = measured
    found = SkinDistances.of(replace(body, mirror=None), patches.vertices)
    np.testing.assert_allclose(found.to_mirror_image, skin.to_mirror_image, atol=0.02)
