# SPDX-License-Identifier: GPL-3.0-or-later
"""Use Character on a character that Rigify made the rig of; `test_rigify.py` runs this in Blender.

Environment: W2W_ZIP the extension, W2W_OUT where the report goes.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import addon_utils
import bpy

PROJECT = Path(__file__).resolve().parents[2]


def main() -> None:
    """Make the rig, skin it with our body, press the button."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["W2W_ZIP"], repo="user_default", enable_on_install=True
    )
    report = {"rigify": addon_utils.enable("rigify", default_set=True) is not None}
    if report["rigify"]:
        bpy.data.batch_remove([*bpy.data.objects])
        report |= made_by_rigify()
    Path(os.environ["W2W_OUT"], "report.json").write_text(json.dumps(report, indent=2))


def made_by_rigify() -> dict[str, object]:
    """Rigify's human, generated, with our skin on its bones."""
    sys.path[:0] = [str(PROJECT), str(PROJECT / "blender_addon")]
    import numpy as np

    from tests.scene.other_rigs import add_skin, distance_from_itself, fit_metarig
    from w2w.core.body.body import JOINT_NAMES, Body
    from w2w.core.retargeting.bone_maps import best_match

    body = Body.bundled()
    bpy.ops.object.armature_human_metarig_add()
    metarig = bpy.context.object
    fit_metarig(metarig, body)
    bpy.ops.object.mode_set(mode="POSE")
    bpy.ops.pose.rigify_generate()
    bpy.ops.object.mode_set(mode="OBJECT")
    rig = next(item for item in bpy.data.objects if item.type == "ARMATURE" and item != metarig)
    bones = [bone.name for bone in rig.data.bones]
    bone_map, matched = best_match(bones)
    joint_of = {bones[bone]: JOINT_NAMES[joint] for joint, bone in matched.items()}
    twists = {
        f"{bone}.001": joint for bone, joint in joint_of.items() if "_" in joint and f"{bone}.001" in bones
    }
    mesh = add_skin(body, rig, joint_of | twists)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.w2w.use_character()
    study = bpy.context.scene.w2w.body.w2w
    return {
        "bones": len(bones),
        "map": bone_map.name,
        "joints": len(matched),
        "deforming": all(bones[bone].startswith("DEF-") for bone in matched.values()),
        "twists": len(twists),
        "fit": study.fit,
        "meshes": [row.mesh.name for row in study.character_meshes],
        "from_itself": float(np.median(distance_from_itself(body, mesh))),
    }


main()
