"""Garments that follow a body carry its patches: rigid, at no offset, by cloth, and what cannot be worn."""

import bpy
import numpy as np
import pytest

from w2w.core.garments.cut import cut
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w.core.motion.motion import Motion
from w2w.core.motion.run_up import with_run_up
from w2w.core.motion.skinning import patch_matrices, skinning_transforms
from w2w.scene.base.actions import show_action, write_action
from w2w.scene.base.body import add_skinned, body_of
from w2w.scene.base.steps import without_pauses
from w2w.scene.cloth.bake import DressedBody, GarmentBaker, check_garment, cover_of, follow

from ..conftest import bake, difference


@pytest.fixture
def short(waving):
    return Motion(waving.rotations[:24], waving.pelvis[:24], waving.rate, "waving", "one", "clip")


def copy_of_skin(objects, name="Second Skin", off=0.0):
    """A mesh as the body's, moved by nothing, so far off the skin."""
    item = bpy.data.objects.new(name, objects.mesh.data.copy())
    for vertex in item.data.vertices:
        vertex.co += off * vertex.normal
    bpy.context.scene.collection.objects.link(item)
    return item


def baker(item, mesh, patches):
    return GarmentBaker(mesh, patches, [item], [cover_of(item, mesh, patches)])


def follow_surface(item, target):
    modifier = item.modifiers.new("Surface Deform", "SURFACE_DEFORM")
    modifier.target = target
    with bpy.context.temp_override(object=item, active_object=item):
        bpy.ops.object.surfacedeform_bind(modifier=modifier.name)
    assert modifier.is_bound


@pytest.mark.slow
def test_a_surface_deform_a_hair_off_feels_what_the_skin_feels(body_in_scene, bundled_body, patches, short):
    item = copy_of_skin(body_in_scene, off=0.001)  # Blender binds nothing that lies on a vertex
    follow_surface(item, body_in_scene.mesh)
    own = cover_of(item, body_in_scene.mesh, patches)
    assert len(own) == len(patches)
    on_cloth = without_pauses(follow(DressedBody(body_in_scene.mesh, [item], [own]), short, patches))
    same = (own.triangles == patches.triangles).all(axis=1)
    assert same.mean() > 0.7  # of triangles that are equally steady another may be chosen
    moved, before = with_run_up(short)
    truth = patch_matrices(bundled_body, patches.triangles[same], moved)[before:]
    distance, angle = difference(on_cloth.matrices[:, same], truth)
    assert distance < 0.002
    assert angle < 3
    error = synthesize(on_cloth.matrices[:, same], on_cloth.rate), synthesize(truth, on_cloth.rate)
    assert np.sqrt(((error[0].acc - error[1].acc) ** 2).mean()) < 0.1
    assert np.sqrt(((error[0].gyr - error[1].gyr) ** 2).mean()) < 0.05


@pytest.mark.slow
def test_a_rigid_offset_is_the_skins_path_and_its_lever_arm(body_in_scene, bundled_body, patches, short):
    """A plate at the head, which one bone moves: where it is follows from the bone alone."""
    plate = bpy.data.objects.new("Plate", bpy.data.meshes.new("Plate"))
    crown = bundled_body.vertices[bundled_body.vertices[:, 2].argmax()]
    corners = [(x, y, 0.05) for x in (-0.06, 0, 0.06) for y in (-0.06, 0, 0.06)]
    faces = [(3 * i + j, 3 * i + j + 3, 3 * i + j + 4, 3 * i + j + 1) for i in (0, 1) for j in (0, 1)]
    plate.data.from_pydata([tuple(crown + corner) for corner in corners], [], faces)
    bpy.context.scene.collection.objects.link(plate)
    group = plate.vertex_groups.new(name="head")
    group.add(list(range(9)), 1.0, "REPLACE")
    modifier = plate.modifiers.new("Armature", "ARMATURE")
    modifier.object = body_in_scene.armature
    own = cover_of(plate, body_in_scene.mesh, patches)
    on_cloth = without_pauses(follow(DressedBody(body_in_scene.mesh, [plate], [own]), short, patches))
    moved, before = with_run_up(short)
    rest = own.matrices(np.array([tuple(crown + corner) for corner in corners])[own.triangles][None])[0]
    head = skinning_transforms(bundled_body, moved)[before:, 15]
    truth = np.broadcast_to(np.eye(4), (len(head), len(own), 4, 4)).copy()
    truth[..., :3, :3] = head[:, None, :, :3] @ rest[:, :3, :3]
    truth[..., :3, 3] = np.einsum("tab,nb->tna", head[..., :3], rest[:, :3, 3]) + head[:, None, :, 3]
    distance, angle = difference(on_cloth.matrices, truth)
    assert distance < 2e-5
    assert angle < 0.02


@pytest.mark.slow
def test_the_scene_is_left_as_it_was(body_in_scene, patches, short):
    item = shirt_on(body_in_scene)
    scene = bpy.context.scene
    scene.render.fps, scene.frame_end = 24, 99
    scene.frame_set(7)
    action = write_action(body_in_scene.armature, short)
    show_action(body_in_scene.armature, action)
    cloth = item.modifiers.new("Cloth", "CLOTH")
    cloth.point_cache.frame_end = 77
    frames = baker(item, body_in_scene.mesh, patches).by_frame(action)
    for _ in range(5):
        next(frames)
    frames.close()
    assert (scene.render.fps, scene.frame_end, scene.frame_current) == (24, 99, 7)
    assert body_in_scene.armature.animation_data.action == action
    assert [found.name for found in bpy.data.actions] == [action.name]
    assert (cloth.settings.time_scale, cloth.point_cache.frame_end) == (1.0, 77)


def shirt_on(objects):
    """A T-shirt that is skinned and no cloth."""
    cloth = cut("tshirt", body_of(objects.mesh)).cloth
    return add_skinned(cloth, objects.armature, bpy.context.scene.collection, "Shirt")


def test_a_bake_has_the_skin_and_what_is_worn(body_in_scene, patches, short):
    item = shirt_on(body_in_scene)
    action = write_action(body_in_scene.armature, short)
    show_action(body_in_scene.armature, action)
    found = without_pauses(baker(item, body_in_scene.mesh, patches).by_frame(action))
    skin = bake(body_in_scene.mesh, patches, action)
    np.testing.assert_array_equal(found.matrices, skin.matrices)
    assert found.path == "general"
    assert found.reason == f"{len(found.on_cloth.patches)} sensors are on Shirt"
    assert found.on_cloth.rate == pytest.approx(60)
    gap = found.on_cloth.matrices[::2, :, :3, 3] - skin.matrices[:, found.on_cloth.patches][..., :3, 3]
    gap -= np.median(gap, axis=(0, 1)) * (1, 1, 0)  # the body moves about the origin meanwhile
    assert 0.01 < np.median(np.linalg.norm(gap, axis=2)) < 0.06


@pytest.mark.slow
def test_signals_of_a_body_moved_by_more_than_bones_are_baked_frame_by_frame(body_in_scene, patches, short):
    item = shirt_on(body_in_scene)
    scene = bpy.context.scene
    scene.render.fps = 30
    action = write_action(body_in_scene.armature, short)
    show_action(body_in_scene.armature, action)
    body_in_scene.armature.constraints.new("LIMIT_LOCATION")
    found = without_pauses(baker(item, body_in_scene.mesh, patches).by_frame(action))
    assert found.on_cloth.rate == pytest.approx(30)
    skinned = synthesize(found.on_cloth.matrices, found.on_cloth.rate, Synthesis())
    assert skinned.n_samples >= synthesize(found.matrices, found.rate, Synthesis()).n_samples


@pytest.mark.slow
def test_what_cannot_be_worn_says_why(body_in_scene, patches):
    mesh = body_in_scene.mesh
    loose = copy_of_skin(body_in_scene, "Loose")
    with pytest.raises(ValueError, match="'Loose' does not follow the body: give it a modifier"):
        check_garment(loose, mesh)
    with pytest.raises(ValueError, match="is the body itself"):
        check_garment(mesh, mesh)
    with pytest.raises(ValueError, match="is no mesh with faces"):
        check_garment(body_in_scene.armature, mesh)
    loose.parent = mesh
    loose.location = (4, 0, 0)
    bpy.context.view_layer.update()
    with pytest.raises(ValueError, match=f"'Loose' covers no patch of '{mesh.name}'"):
        cover_of(loose, mesh, patches)


def test_baked_physics_are_refused(body_in_scene):
    item = shirt_on(body_in_scene)
    cloth = item.modifiers.new("Cloth", "CLOTH")
    cloth.point_cache.frame_end = 2
    with bpy.context.temp_override(point_cache=cloth.point_cache, scene=bpy.context.scene, object=item):
        bpy.ops.ptcache.bake(bake=True)
    assert cloth.point_cache.is_baked
    with pytest.raises(ValueError, match="physics of 'Shirt' are baked"):
        check_garment(item, body_in_scene.mesh)


@pytest.mark.slow
def test_a_lattice_is_one_more_way_to_follow(body_in_scene, bundled_body, patches, short):
    """Here it hangs at the head and moves a cap."""
    lattice = bpy.data.objects.new("Lattice", bpy.data.lattices.new("Lattice"))
    bpy.context.scene.collection.objects.link(lattice)
    lattice.parent, lattice.parent_type, lattice.parent_bone = body_in_scene.armature, "BONE", "head"
    cap = copy_of_skin(body_in_scene, "Cap")
    cap.modifiers.new("Lattice", "LATTICE").object = lattice
    bpy.context.view_layer.update()
    check_garment(cap, body_in_scene.mesh)
    own = cover_of(cap, body_in_scene.mesh, patches)
    on_cloth = without_pauses(follow(DressedBody(body_in_scene.mesh, [cap], [own]), short, patches))
    assert np.isfinite(on_cloth.matrices).all()
    assert patch_matrices(bundled_body, patches.triangles, short).shape[1:] == on_cloth.matrices.shape[1:]
