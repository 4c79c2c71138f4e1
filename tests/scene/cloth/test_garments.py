"""Our own garments in the scene: cut for the body, cloth that lies on it, cut anew for another shape."""

import bpy
import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.body.shapes import shaped
from w2w.core.garments.cut import KINDS, cut
from w2w.core.imu.cover import cover
from w2w.core.motion.motion import Motion
from w2w.core.patches.patches import sample_patches
from w2w.scene.bake import why_not_fast
from w2w.scene.base.body import add_body, body_of, rest_vertices
from w2w.scene.cloth.bake import followed
from w2w.scene.cloth.garments import HELD, dress, lie_on, lies_on_nothing, refit


@pytest.mark.parametrize("kind", KINDS)
def test_a_garment_is_skinned_held_and_lies_on_the_body(body_in_scene, kind):
    item = dress(body_in_scene.mesh, kind)
    assert [modifier.type for modifier in item.modifiers] == ["ARMATURE", "CLOTH"]
    assert item.parent == body_in_scene.armature
    held = item.vertex_groups[HELD].index
    assert 20 < sum(any(g.group == held for g in vertex.groups) for vertex in item.data.vertices) < 200
    assert body_in_scene.mesh.collision is not None
    dress(body_in_scene.mesh, KINDS[0])
    assert sum(modifier.type == "COLLISION" for modifier in body_in_scene.mesh.modifiers) == 1


def test_a_body_that_cloth_lies_on_is_still_read_from_its_curves(body_in_scene):
    before = why_not_fast(body_in_scene.mesh, None)
    lie_on(body_in_scene.mesh)
    assert why_not_fast(body_in_scene.mesh, None) == before
    lies_on_nothing(body_in_scene.mesh)
    assert [modifier.type for modifier in body_in_scene.mesh.modifiers] == ["ARMATURE"]


@pytest.mark.slow
def test_a_body_of_another_shape_has_its_garment_cut_anew(empty_file, bundled_body):
    objects = add_body(bundled_body, empty_file.collection)
    item = dress(objects.mesh, "tshirt")
    before = rest_vertices(item)
    refit(item, objects.mesh, cut("tshirt", body_of(objects.mesh)))
    np.testing.assert_array_equal(rest_vertices(item), before)
    larger = shaped(bundled_body, weight=75.0)
    objects.mesh.data.vertices.foreach_set("co", larger.vertices.astype(np.float32).ravel())
    refit(item, objects.mesh, cut("tshirt", body_of(objects.mesh)))
    after = cut("tshirt", body_of(objects.mesh)).cloth
    np.testing.assert_allclose(rest_vertices(item), after.vertices, atol=1e-6)
    assert not np.array_equal(rest_vertices(item), before)
    assert item.modifiers["Cloth"].settings.vertex_group_mass == HELD
    held = item.vertex_groups[HELD].index
    assert sum(any(g.group == held for g in vertex.groups) for vertex in item.data.vertices) > 20


def test_an_unknown_garment_is_refused(body_in_scene):
    with pytest.raises(ValueError, match="no garment called 'hat'"):
        dress(body_in_scene.mesh, "hat")


@pytest.mark.slow
@pytest.mark.usefixtures("empty_file")
def test_a_shirt_hangs_on_the_body_and_gives_the_same_bytes_again():
    body = Body.bundled()
    patches = sample_patches(body, n=64, seed=0)
    pelvis = np.tile(body.joints[0], (12, 1))
    lean = np.tile(np.eye(3), (12, 24, 1, 1))
    standing = Motion(lean, pelvis, 50.0, "standing", "one", "clip")
    cloth = cut("tshirt", body).cloth
    own = cover(cloth.vertices, cloth.faces, body, patches)
    first, second = (followed(body, patches, {"tshirt": own}, standing) for _ in range(2))
    assert first.matrices.tobytes() == second.matrices.tobytes()
    assert np.isfinite(first.matrices).all()
    assert not bpy.data.objects
    places = first.matrices[-1, :, :3, 3] + (0, 0, body.joints[0, 2] - pelvis[0, 2])
    skin = body.vertices[patches.vertices[own.patches]] - pelvis[0] * (1, 1, 0)
    away = np.linalg.norm(places - skin, axis=1)
    assert np.median(away) < 0.06
    assert away.max() < 0.2
    at_rest = own.matrices(cloth.vertices[own.triangles][None])[0, :, :3, 3] - pelvis[0] * (1, 1, 0)
    assert np.linalg.norm(places - at_rest, axis=1).max() > 0.01, "cloth that does not move is no cloth"
