# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies adopted from Blender: rigged FBX and meshes in the scene, in any place, turn, unit and spelling."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from scipy.spatial.transform import Rotation

from w2w.core.adopt.smpl import BodyError, read_mesh
from w2w.core.body.body import JOINT_INDEX, JOINT_NAMES, N_JOINTS, Y_UP_TO_Z_UP
from w2w.core.body.landmarks import has_smpl_topology
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import skin, skinning_transforms
from w2w.scene.base.body import add_body
from w2w.scene.body.adopt import adopt_file, adopt_mesh

from ..rings import by_day

pytestmark = pytest.mark.usefixtures("empty_file")

FIXTURE = "fixture_smplbody_rigged.fbx"


@pytest.fixture(scope="module")
def smpl_truth(shared_data):
    """The man's T-pose, in SMPL's vertex order and W2W's axes."""
    folder = shared_data / "smpl_body"
    vertices, polygons = read_mesh(folder / "human_man.obj")
    order = np.empty(len(vertices), dtype=int)
    order[np.load(folder / "smpl_faces_from_ccby.npy").ravel()] = polygons[:, :3].ravel()
    return vertices[order] @ Y_UP_TO_Z_UP.T


def short_name(joint):
    side, _, part = joint.partition("_")
    return f"{side[0].upper()}_{part.capitalize()}" if part else joint.capitalize()


def rename_bones(objects, names):
    for joint, name in names.items():
        objects.armature.data.bones[joint].name = name  # Blender renames the vertex group along
    assert set(names.values()) <= set(objects.mesh.vertex_groups.keys())


def test_a_rigged_fbx_with_official_bone_names(shared_data, smpl_truth):
    before = {item.name for item in bpy.data.objects}
    body = adopt_file(shared_data / "smpl_body" / FIXTURE)
    assert {item.name for item in bpy.data.objects} == before
    assert has_smpl_topology(body)
    offset = body.vertices - smpl_truth
    assert np.abs(offset - offset[0]).max() < 1e-6
    assert body.joints[JOINT_INDEX["left_hip"], 0] > 0 > body.joints[JOINT_INDEX["right_hip"], 0]
    for vertex, joint in ((1961, "left_elbow"), (4662, "right_knee"), (411, "head")):
        assert body.weights[vertex, JOINT_INDEX[joint]] > 0.5


@pytest.mark.slow
def test_the_fbx_and_the_bare_mesh_of_the_same_man_agree(shared_data):
    rigged = adopt_file(shared_data / "smpl_body" / FIXTURE)
    bare = adopt_file(shared_data / "smpl_body" / "human_man.obj")
    np.testing.assert_array_equal(rigged.faces, bare.faces)
    shift = (rigged.vertices - bare.vertices)[0]
    np.testing.assert_allclose(rigged.vertices - shift, bare.vertices, atol=1e-6)
    limbs = [
        JOINT_INDEX[f"{side}_{part}"] for side in ("left", "right") for part in ("knee", "elbow", "wrist")
    ]
    gap = np.linalg.norm(rigged.joints[limbs] - shift - bare.joints[limbs], axis=1)
    assert gap.max() < 0.03


@pytest.mark.parametrize(
    "spelling", by_day(["m_avg_L_Hip"], ["left_hip", "L_Hip", "m_avg_L_Hip", "f_avg_L_Hip"])
)
def test_bones_are_known_in_every_spelling(bundled_body, spelling):
    objects = add_body(bundled_body)
    prefix = spelling.removesuffix("L_Hip")
    if spelling != "left_hip":
        rename_bones(objects, {joint: prefix + short_name(joint) for joint in JOINT_NAMES})
    body = adopt_mesh(objects.mesh)
    shift = np.array([*bundled_body.joints[0, :2], 0])
    np.testing.assert_allclose(body.vertices, bundled_body.vertices - shift, atol=1e-6)
    np.testing.assert_allclose(body.joints, bundled_body.joints - shift, atol=1e-6)
    np.testing.assert_allclose(body.weights, bundled_body.weights, atol=1e-6)


@pytest.mark.slow
def test_where_it_stands_how_it_is_turned_and_its_unit_do_not_matter(bundled_body):
    objects = add_body(bundled_body)
    turn = Rotation.from_euler("xz", [90, 90], degrees=True)
    objects.armature.matrix_world = Matrix(to_matrix(turn, [3, -7, 2]) @ np.diag([100, 100, 100, 1]))
    bpy.context.view_layer.update()
    body = adopt_mesh(objects.mesh)
    shift = np.array([*bundled_body.joints[0, :2], 0])
    np.testing.assert_allclose(body.vertices, bundled_body.vertices - shift, atol=1e-5)


def to_matrix(rotation, place):
    world = np.eye(4)
    world[:3, :3], world[:3, 3] = rotation.as_matrix(), place
    return world


@pytest.mark.slow
def test_a_rig_in_an_a_pose_comes_in_the_t_pose(bundled_body):
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    for joint, sign in (("left_shoulder", 1), ("right_shoulder", -1)):
        rotations[0, JOINT_INDEX[joint]] = Rotation.from_rotvec([0, sign * 0.8, 0]).as_matrix()
    transforms = skinning_transforms(bundled_body, Motion(rotations, bundled_body.joints[:1], 30))
    posed = type(bundled_body)(
        skin(bundled_body, transforms)[0],
        bundled_body.faces,
        np.einsum("jab,jb->ja", transforms[0, :, :, :3], bundled_body.joints) + transforms[0, :, :, 3],
        bundled_body.weights,
    )
    body = adopt_mesh(add_body(posed).mesh)
    shift = np.array([*bundled_body.joints[0, :2], 0])
    np.testing.assert_allclose(body.vertices, bundled_body.vertices - shift, atol=1e-4)


@pytest.mark.slow
def test_fingers_stand_in_for_missing_hands(bundled_body):
    objects = add_body(bundled_body)
    rename_bones(objects, {"left_hand": "left_middle1", "right_hand": "right_middle1"})
    body = adopt_mesh(objects.mesh)
    np.testing.assert_allclose(body.weights, bundled_body.weights, atol=1e-6)
    shift = np.array([*bundled_body.joints[0, :2], 0])
    np.testing.assert_allclose(body.joints, bundled_body.joints - shift, atol=1e-6)


def test_other_objects_are_refused_in_words(bundled_body):
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    with pytest.raises(BodyError, match="'Lamp' is a light: choose the mesh"):
        adopt_mesh(lamp)
    bare = bpy.data.meshes.new("bare")
    bare.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    triangle = bpy.data.objects.new("triangle", bare)
    with pytest.raises(BodyError, match=r"no armature, and its faces are not SMPL's: expected 6890.*found 3"):
        adopt_mesh(triangle)
    with pytest.raises(BodyError, match="has no faces"):
        adopt_mesh(bpy.data.objects.new("nothing", bpy.data.meshes.new("nothing")))
    objects = add_body(bundled_body)
    rename_bones(objects, {"left_knee": "rope", "head": "skull"})
    with pytest.raises(BodyError, match=r"no bone was found for left_knee, head among pelvis"):
        adopt_mesh(objects.mesh)


def test_files_that_hold_no_body_are_refused_in_words(shared_data, tmp_path):
    (tmp_path / "empty.fbx").write_bytes(b"")
    with pytest.raises(BodyError, match=r"empty\.fbx: the file is empty"):
        adopt_file(tmp_path / "empty.fbx")
    walk = next((shared_data / "mixamo").rglob("AirSquat.fbx"))
    with pytest.raises(BodyError, match=r"expected a mesh moved by bones with SMPL's names, found only: arm"):
        adopt_file(walk)
