# SPDX-License-Identifier: GPL-3.0-or-later
"""A garment is followed frame by frame, and frames in which its cloth has caught are counted."""

import bpy
import numpy as np
import pytest

from w2w.core.imu.cover import CAUGHT, Cover
from w2w.scene.cloth.bake import SensorTriangles

SIDE, FRAMES = 0.1, 6


@pytest.fixture
def pulled(empty_file):
    """A square of which one corner is drawn away in six frames."""
    mesh = bpy.data.meshes.new("Square")
    mesh.from_pydata([(0, 0, 0), (SIDE, 0, 0), (SIDE, SIDE, 0), (0, SIDE, 0)], [], [(0, 1, 2, 3)])
    item = bpy.data.objects.new("Square", mesh)
    empty_file.collection.objects.link(item)
    item.shape_key_add(name="Basis")
    key = item.shape_key_add(name="Pulled")
    key.data[2].co.y = 4 * SIDE
    for frame, value in ((1, 0.0), (FRAMES, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    return item


def follow(item):
    own = Cover(np.array([0]), np.array([[0, 1, 2]]), np.eye(3)[None])
    followed = SensorTriangles(item, own, FRAMES)
    for number in range(FRAMES):
        bpy.context.scene.frame_set(number + 1)
        followed.take(number)
    return followed


def test_frames_in_which_cloth_is_drawn_out_are_counted(pulled):
    cloth = pulled.modifiers.new("Cloth", "CLOTH")
    pulled.vertex_groups.new(name="all").add([0, 1, 2, 3], 1.0, "REPLACE")
    cloth.settings.vertex_group_mass = "all"
    found = follow(pulled)
    corners = found.corners[:, 0]
    times = np.linalg.norm(corners[:, 2] - corners[:, 1], axis=1) / SIDE
    assert 0 < found.caught == (times > CAUGHT).sum() < FRAMES


def test_what_is_not_simulated_may_be_drawn_out(pulled):
    found = follow(pulled)
    assert found.caught == 0
    np.testing.assert_allclose(found.corners[0, 0], [(0, 0, 0), (SIDE, 0, 0), (SIDE, SIDE, 0)], atol=1e-6)
    np.testing.assert_allclose(found.corners[-1, 0, 2], (SIDE, 4 * SIDE, 0), atol=1e-6)


def test_cloth_that_flies_apart_is_refused(pulled):
    pulled.data.shape_keys.key_blocks["Pulled"].data[2].co.y = 40
    with pytest.raises(ValueError, match="the cloth of 'Square' flew apart in this clip"):
        follow(pulled)
