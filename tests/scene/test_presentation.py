# SPDX-License-Identifier: GPL-3.0-or-later
"""The way a body faces, by which its picture is taken from the front."""

import bpy
import numpy as np
import pytest

from w2w.scene.presentation import facing, stage


@pytest.mark.parametrize("degrees", [0, 50, -130])
def test_a_body_faces_where_its_hips_and_its_armature_turn(body_in_scene, degrees):
    armature = body_in_scene.armature
    pelvis = armature.pose.bones["pelvis"]
    turn = np.radians(degrees)
    pelvis.rotation_mode = "XYZ"
    rest = pelvis.bone.matrix_local.to_3x3()
    around_z = rest.inverted() @ type(rest).Rotation(turn, 3, "Z") @ rest
    pelvis.rotation_euler = around_z.to_euler()
    bpy.context.view_layer.update()
    assert facing(body_in_scene.mesh) == pytest.approx(turn, abs=1e-4)
    armature.rotation_euler.z = 0.3
    bpy.context.view_layer.update()
    assert facing(body_in_scene.mesh) == pytest.approx(turn + 0.3, abs=1e-4)


def test_a_stage_leaves_nothing(body_in_scene):
    before = [*bpy.data.scenes], [*bpy.data.objects], [*bpy.data.cameras]
    with pytest.raises(ZeroDivisionError), stage([body_in_scene.mesh], 64):
        raise ZeroDivisionError
    assert ([*bpy.data.scenes], [*bpy.data.objects], [*bpy.data.cameras]) == before
