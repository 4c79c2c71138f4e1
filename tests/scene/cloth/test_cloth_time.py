"""Blender's cloth falls as things fall, at any frame rate and any number of steps."""

import bpy
import numpy as np
import pytest

from w2w.scene.cloth.garments import REAL_TIME_RATE, real_time_speed

SECONDS = 0.4


def fall(scene, rate, steps, speed):
    """Acceleration of a free piece of cloth, m/s2."""
    scene.render.fps = rate
    mesh = bpy.data.meshes.new("piece")
    mesh.from_pydata([(0, 0, 0), (0.02, 0, 0), (0.02, 0.02, 0), (0, 0.02, 0)], [], [(0, 1, 2, 3)])
    piece = bpy.data.objects.new("piece", mesh)
    scene.collection.objects.link(piece)
    cloth = piece.modifiers.new("Cloth", "CLOTH")
    cloth.settings.quality, cloth.settings.air_damping = steps, 0
    cloth.settings.time_scale = speed
    heights = []
    for frame in range(1, round(SECONDS * rate) + 2):
        scene.frame_set(frame)
        shown = piece.evaluated_get(bpy.context.evaluated_depsgraph_get())
        heights.append(np.mean([vertex.co.z for vertex in shown.data.vertices]))
    return 2 * np.polyfit(np.arange(len(heights)) / rate, heights, 2)[0]


@pytest.mark.parametrize(("rate", "steps"), [(24, 5), (24, 12), (50, 5), (60, 5), (72, 10), (100, 7)])
def test_cloth_falls_with_gravity(empty_file, rate, steps):
    assert fall(empty_file, rate, steps, real_time_speed(1.0, rate, steps)) == pytest.approx(-9.81, rel=1e-3)


def test_left_alone_blender_makes_one_step_too_many(empty_file):
    """If this fails, Blender counts its steps otherwise: `real_time_speed` then has nothing to pass over."""
    wrong = fall(empty_file, 24, 10, REAL_TIME_RATE / 24)
    assert wrong == pytest.approx(-9.81 * 1.21, rel=1e-3)


def test_a_users_own_speed_stays_in_proportion():
    assert real_time_speed(0.5, 60, 5) == pytest.approx(0.5 * REAL_TIME_RATE / 60, rel=1e-4)
