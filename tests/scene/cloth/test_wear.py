"""A garment out of somebody's .blend file follows the body of the run."""

import bpy
import numpy as np
import pytest

from w2w.core.garments.cut import cut
from w2w.core.motion.motion import Motion
from w2w.scene.base.body import add_body, add_skinned
from w2w.scene.cloth.bake import fitted, followed


@pytest.fixture
def wardrobe(tmp_path, empty_file, bundled_body):
    """A file with our body, a shirt that an armature moves, and a scarf that follows nothing."""
    objects = add_body(bundled_body, empty_file.collection)
    shirt = add_skinned(cut("tshirt", bundled_body).cloth, objects.armature, empty_file.collection, "Shirt")
    shirt.modifiers.new("Ripples", "SMOOTH").factor = 0.0
    scarf = bpy.data.objects.new("Scarf", shirt.data.copy())
    empty_file.collection.objects.link(scarf)
    path = tmp_path / "wardrobe.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return path


def test_it_covers_and_follows_the_body_that_wears_it(wardrobe, bundled_body, patches, waving):
    short = Motion(waving.rotations[:12], waving.pelvis[:12], waving.rate)
    garment = f"{wardrobe}:Shirt"
    own = fitted(garment, bundled_body, patches)
    assert 10 < len(own) < len(patches)
    worn = followed(bundled_body, patches, {garment: own}, short)
    assert worn.patches.tolist() == own.patches.tolist()
    turns = np.swapaxes(worn.matrices[:1, :, :3, :3], -1, -2) @ worn.matrices[..., :3, :3]
    assert np.abs(turns - np.eye(3)).max() > 0.01, "it stands still"
    assert not bpy.data.objects
    assert not bpy.data.libraries


def test_what_is_wrong_with_a_file_is_said(wardrobe, bundled_body, patches):
    with pytest.raises(ValueError, match=r"holds no object 'Coat'; its objects are: .*Scarf, Shirt"):
        fitted(f"{wardrobe}:Coat", bundled_body, patches)
    with pytest.raises(ValueError, match=r"'Scarf' in .* follows no body: in that file let it follow"):
        fitted(f"{wardrobe}:Scarf", bundled_body, patches)
    broken = wardrobe.with_name("broken.blend")
    broken.write_bytes(b"BLENDER, but not")
    with pytest.raises(ValueError, match=r"cannot be read as a \.blend file"):
        fitted(f"{broken}:Shirt", bundled_body, patches)
    assert not bpy.data.objects
