# SPDX-License-Identifier: GPL-3.0-or-later
"""USD: what Blender wrote comes back as the FBX it was made of; what is no whole file is refused."""

import shutil
import sys
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

import w2w
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.scene.motion import importers

FORMS = ("usda", "usdc", "usdz")
HAS_USD = bpy.app.version >= (4, 4)  # its own library, open to Python


@pytest.fixture(scope="module")
def written(shared_data, tmp_path_factory):
    """A run that Blender wrote in all forms, and the FBX it read."""
    fbx = shared_data / "mixamo/kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx"
    folder = tmp_path_factory.mktemp("usd")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.import_scene.fbx(filepath=str(fbx))
    end = max(action.frame_range[1] for action in bpy.data.actions)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 0, int(end)
    for form in FORMS:
        bpy.ops.wm.usd_export(
            filepath=str(folder / f"run.{form}"), export_animation=True, export_armatures=True
        )
    return fbx, folder


@pytest.mark.parametrize("form", FORMS)
def test_a_motion_comes_back_as_the_fbx_it_was_made_of(written, bundled_body, form):
    if form != "usda" and not HAS_USD:
        pytest.skip("this Blender's USD is not open to Python")
    fbx, folder = written
    path = sys.path.copy()
    expected, found = w2w.load(fbx)[0], w2w.load(folder / f"run.{form}")[0]
    assert found.rate == pytest.approx(expected.rate)
    assert abs(found.n_frames - expected.n_frames) <= 1
    a, b = (joint_transforms(bundled_body, motion)[0] for motion in (expected, found))
    n_frames = min(len(a), len(b))
    np.testing.assert_allclose(a[:n_frames], b[-n_frames:], atol=0.02)
    assert sys.path == path


def test_a_binary_file_under_the_common_name_keeps_its_own_rate(written, tmp_path):
    if not HAS_USD:
        pytest.skip("this Blender's USD is not open to Python")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.context.scene.render.fps = 48
    shutil.copyfile(written[1] / "run.usdc", tmp_path / "run.usd")
    assert w2w.load(tmp_path / "run.usd")[0].rate == pytest.approx(w2w.load(written[0])[0].rate)
    assert bpy.context.scene.render.fps == 48


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("part", [0.05, 0.5, 0.98])
def test_a_file_cut_short_is_refused(written, tmp_path, form, part):
    data = (written[1] / f"run.{form}").read_bytes()
    (tmp_path / f"cut.{form}").write_bytes(data[: int(len(data) * part)])
    with pytest.raises(ValueError, match="cut short|damaged" if HAS_USD else "cut short|Blender 4"):
        w2w.load(tmp_path / f"cut.{form}")


def test_an_archive_of_other_things_is_refused(tmp_path):
    (tmp_path / "text.txt").write_text("no scene")
    shutil.make_archive(str(tmp_path / "other"), "zip", tmp_path, "text.txt")
    (tmp_path / "other.zip").rename(tmp_path / "other.usdz")
    with pytest.raises(ValueError, match="damaged" if HAS_USD else "Blender 4"):
        w2w.load(tmp_path / "other.usdz")


def test_binary_parts_in_other_files_are_refused(tmp_path, written):
    if not HAS_USD:
        pytest.skip("this Blender's USD is not open to Python")
    assert w2w.load(written[1] / "run.usdc")  # opens USD's library to Python
    from pxr import Sdf

    layer = Sdf.Layer.CreateNew(str(tmp_path / "whole.usdc"))
    layer.subLayerPaths.append("../rig.usda")
    layer.Save()
    with pytest.raises(ValueError, match=r"parts of it lie in other files \(\.\./rig\.usda\)"):
        w2w.load(tmp_path / "whole.usdc")


def test_a_blender_built_without_usd_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(
        importers, "bpy", SimpleNamespace(ops=SimpleNamespace(wm=SimpleNamespace()))
    )  # as Debian's
    with pytest.raises(UnusableMotion, match=r"built without USD: export the file as \.glb or FBX"):
        importers.import_usd(tmp_path / "run.usdc")
