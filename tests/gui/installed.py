# SPDX-License-Identifier: GPL-3.0-or-later
"""Install an extension zip into a bare `bpy` and take a small study through it; run by `test_zips.py`.

Arguments: the zip, and the file for what was found. BLENDER_USER_RESOURCES names an empty folder.
"""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

import bpy

PACKAGE = "bl_ext.user_default.w2w"
N_PATCHES = 24


def main(zip_path: str, report: str) -> None:
    """Install, study, report."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=True)
    modules = ("w2w", "scipy", "matplotlib", "threadpoolctl", "loky", "cloudpickle")
    found = {name: importlib.import_module(name).__file__ for name in modules}
    bpy.ops.w2w.add_body()
    study = bpy.context.scene.w2w.body.w2w
    study.patch_count = N_PATCHES
    bpy.ops.w2w.import_folder(directory=str(make_library(Path(report).parent / "library")))
    bpy.ops.w2w.place_patches()
    bpy.ops.w2w.bake_signals()
    bpy.ops.w2w.rank_patches()
    study = bpy.context.scene.w2w.body.w2w
    Path(report).write_text(
        json.dumps(
            {
                "blender": bpy.app.version_string,
                "modules": found,
                "resources": bpy.utils.resource_path("USER"),
                "has_preferences": bpy.context.preferences.addons[PACKAGE].preferences is not None,
                "baked": sum(bool(clip.signals) for clip in study.clips),
                "heatmaps": len(bpy.context.scene.w2w.body.data.color_attributes),
                "best_expected_f1": study.regions[0].f1,
            }
        )
    )
    bpy.ops.preferences.addon_disable(module=PACKAGE)


def make_library(folder: Path) -> Path:
    """Three motions of each of two activities: one arm or one leg swings, about an axis of each motion."""
    import numpy as np
    from scipy.spatial.transform import Rotation

    from w2w.core.motion.motion import Motion

    time = np.arange(90) / 30
    for activity, joint in (("waving", 17), ("kicking", 1)):
        (folder / activity).mkdir(parents=True)
        for number in range(3):
            angles = (0.8 + 0.1 * number) * np.sin(2 * np.pi * (0.8 + 0.1 * number) * time)
            rotations = np.tile(np.eye(3), (len(time), 24, 1, 1))
            rotations[:, joint] = Rotation.from_rotvec(angles[:, None] * [1.0, 0.6 * number, 0.0]).as_matrix()
            pelvis = np.tile([0.0, 0.0, 0.95], (len(time), 1))
            Motion(rotations, pelvis, 30.0).save(folder / activity / f"{activity} {number}.npz")
    return folder


if __name__ == "__main__":
    main(*sys.argv[1:])
