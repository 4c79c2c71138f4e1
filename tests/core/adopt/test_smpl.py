# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes with SMPL's faces, in any vertex order, pose, axes and unit, adopted as bodies."""

import pickle
import struct

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import sparse
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tools.make_smpl_numbering import describe_topology
from w2w.core.adopt import smpl, topology
from w2w.core.adopt.registration import register
from w2w.core.adopt.rest_pose import in_t_pose, metres_per_unit, to_axes, with_smpl_shoulders
from w2w.core.adopt.smpl import load_body, read_mesh
from w2w.core.adopt.topology import NUMBERING, QUADS_SHA256, TRIANGLES_SHA256, recognise
from w2w.core.body.body import JOINT_INDEX, MIRRORED_JOINTS, N_JOINTS, PARENTS, Y_UP_TO_Z_UP
from w2w.core.body.landmarks import has_smpl_topology
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import skin, skinning_transforms

# --- recognising the face list


@pytest.fixture(scope="module")
def smpl_faces(shared_data):
    return np.load(shared_data / "smpl_body" / "smpl_faces_from_ccby.npy")


@pytest.fixture(scope="module")
def a_pose(shared_data):
    """Vertices in SMPL's order and mostly quads."""
    return read_mesh(shared_data / "smpl_body" / "m_smpl_average_A40.obj")


@pytest.fixture
def without_table(monkeypatch, tmp_path):
    """As in the Blender extension."""
    for module in (smpl, topology):
        monkeypatch.setattr(module, "NUMBERING", tmp_path / "none.npz")


@pytest.mark.usefixtures("without_table")
def test_without_the_table_a_mesh_is_refused_and_says_what_to_give(shared_data):
    with pytest.raises(ValueError, match=r"give the official SMPL model \(\.npz or \.pkl\)"):
        load_body(shared_data / "smpl_body" / "m_smpl_average_A40.obj")


@pytest.mark.usefixtures("without_table")
def test_without_the_table_a_rigged_body_keeps_its_own_order(bundled_body):
    polygons = np.column_stack([bundled_body.faces, np.full(len(bundled_body.faces), -1)])
    body = smpl.body_from_rig(
        bundled_body.vertices, polygons, bundled_body.joints, bundled_body.weights, "own"
    )
    np.testing.assert_array_equal(body.faces, bundled_body.faces)


def as_set(faces):
    start = faces.argmin(axis=1)[:, None]
    return set(map(tuple, np.take_along_axis(faces, (start + np.arange(3)) % 3, axis=1).tolist()))


@pytest.mark.slow
def test_what_is_stored_of_smpl_s_faces_is_what_they_give(smpl_faces, a_pose):
    arrays, triangles, quads = describe_topology(smpl_faces, a_pose[1])
    assert (triangles, quads) == (TRIANGLES_SHA256, QUADS_SHA256)
    with np.load(NUMBERING) as stored:
        assert set(stored.files) == set(arrays)
        for name, array in arrays.items():
            np.testing.assert_array_equal(stored[name], array)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "quads", "clockwise"), [(0, False, False), (2, True, True)])
def test_faces_are_recognised_in_any_order_and_sides_paired(smpl_faces, a_pose, seed, quads, clockwise):
    generator = np.random.default_rng(seed)
    polygons = a_pose[1] if quads else smpl_faces
    renamed = generator.permutation(6890)
    shuffled = np.where(polygons >= 0, renamed[polygons], -1)[generator.permutation(len(polygons))]
    if not quads:
        shuffled = np.roll(shuffled, seed + 1, axis=1)
    if clockwise:
        shuffled = np.where(shuffled[:, -1:] >= 0, shuffled[:, ::-1], np.roll(shuffled[:, ::-1], -1, axis=1))
    vertices = np.empty_like(a_pose[0])
    vertices[renamed] = a_pose[0]
    mesh = recognise(shuffled, vertices)
    np.testing.assert_array_equal(mesh.order, renamed)
    assert as_set(mesh.faces) == as_set(smpl_faces)
    mirror = mesh.mirror
    np.testing.assert_array_equal(mirror[mirror], np.arange(6890))
    assert as_set(mirror[smpl_faces][:, ::-1]) == as_set(smpl_faces)
    gap = a_pose[0][mirror] * [-1, 1, 1] - a_pose[0]
    assert np.linalg.norm(gap, axis=1).max() < 0.02  # the average man is not quite symmetric
    assert (mirror == np.arange(6890)).sum() > 100


@pytest.mark.slow
def test_a_single_flipped_edge_is_another_mesh(smpl_faces, a_pose):
    faces = smpl_faces.copy()
    a, b, c = faces[0]
    other = next(i for i, face in enumerate(faces) if i and {a, b} <= set(face.tolist()))
    d = next(corner for corner in faces[other] if corner not in (a, b))
    faces[0], faces[other] = (a, d, c), (d, b, c)
    assert recognise(faces, a_pose[0]) is None
    assert recognise(smpl_faces[1:], a_pose[0]) is None


@pytest.mark.slow
def test_a_mirrored_mesh_is_numbered_as_the_person_it_shows(smpl_faces, a_pose):
    """Its left arm is the one at the left of its front, though the file's maker took it for the right."""
    mesh = recognise(smpl_faces, a_pose[0] * [-1, 1, 1])
    mirrored = (a_pose[0] * [-1, 1, 1])[mesh.order]
    assert np.linalg.norm(mirrored - a_pose[0], axis=1).max() < 0.02


@pytest.mark.slow
def test_the_triangle_order_that_smpl_body_kept_agrees(shared_data, smpl_faces):
    """human_man.obj lists SMPL's triangles in SMPL's order over its own vertices: an independent truth."""
    vertices, polygons = read_mesh(shared_data / "smpl_body" / "human_man.obj")
    truth = np.empty(6890, dtype=int)
    truth[smpl_faces.ravel()] = polygons[:, :3].ravel()
    np.testing.assert_array_equal(recognise(polygons[:, :3], vertices).order, truth)


# --- adopting real bodies


@pytest.fixture(scope="module")
def adopted(shared_data, tmp_path_factory):
    """The man as published in both poses; the woman's A-pose renumbered, in centimetres, lying, as PLY."""
    folder = shared_data / "smpl_body"
    vertices, polygons = read_mesh(folder / "f_smpl_average_A40.obj")
    renamed = np.random.default_rng(5).permutation(len(vertices))
    moved = np.empty_like(vertices)
    moved[renamed] = 100 * vertices[:, [1, 2, 0]] + [300, -20, 8]
    changed = tmp_path_factory.mktemp("adopt") / "woman.ply"
    write_binary_ply(changed, moved, np.where(polygons >= 0, renamed[polygons], -1))
    return {
        "man T": load_body(folder / "human_man.obj"),
        "man A": load_body(folder / "m_smpl_average_A40.obj"),
        "woman A": load_body(changed),
        "woman T": load_body(folder / "human_woman.obj"),
    }


def write_binary_ply(path, vertices, polygons, order="<"):
    name = {"<": "little", ">": "big"}[order]
    header = (
        f"ply\nformat binary_{name}_endian 1.0\ncomment made for a test\nelement vertex {len(vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(polygons)}\nproperty uchar flags\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    rows = []
    for polygon in polygons.tolist():
        corners = [corner for corner in polygon if corner >= 0]
        rows.append(struct.pack(f"{order}BB{len(corners)}i", 0, len(corners), *corners))
    path.write_bytes(header.encode() + vertices.astype(order + "f8").tobytes() + b"".join(rows))


@pytest.mark.parametrize("order", ["<", ">"])
def test_binary_ply_of_mixed_polygons(tmp_path, order):
    vertices = np.arange(15.0).reshape(5, 3)
    polygons = np.array([[0, 1, 2, 3], [0, 1, 4, -1]])
    write_binary_ply(tmp_path / "a.ply", vertices, polygons, order)
    read, faces = read_mesh(tmp_path / "a.ply")
    np.testing.assert_array_equal(read, vertices)
    np.testing.assert_array_equal(faces, polygons)
    (tmp_path / "cut.ply").write_bytes((tmp_path / "a.ply").read_bytes()[:-9])
    with pytest.raises(ValueError, match="cut short"):
        read_mesh(tmp_path / "cut.ply")


def test_text_ply_of_mixed_polygons(tmp_path):
    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nelement face 2\nproperty list uchar int vertex_index\nend_header\n"
        "0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0.5 9\n4 0 1 2 3\n3 0 1 2\n"
    )
    vertices, polygons = read_mesh(tmp_path / "a.ply")
    assert vertices[3].tolist() == [0, 1, 0.5]
    assert polygons.tolist() == [[0, 1, 2, 3], [0, 1, 2, -1]]


@pytest.mark.slow
def test_adopted_bodies_keep_smpl_s_topology_and_the_convention(adopted):
    for body in adopted.values():
        assert has_smpl_topology(body)
        assert body.vertices[:, 2].min() == pytest.approx(0, abs=1e-9)
        hand, other = body.joints[JOINT_INDEX["left_hand"]], body.joints[JOINT_INDEX["right_hand"]]
        assert min(hand[0], -other[0]) > 0.65
        assert abs(hand[2] - body.joints[JOINT_INDEX["left_shoulder"], 2]) < 0.05
        assert body.vertices[332, 1] < body.vertices[3021, 1]  # nose before the small of the back
        volume = np.einsum(
            "fa,fa->", body.vertices[body.faces[:, 0]],
            np.cross(body.vertices[body.faces[:, 1]], body.vertices[body.faces[:, 2]]),
        ) / 6  # fmt: skip
        assert 0.05 < volume < 0.1
    assert adopted["man A"].height == pytest.approx(1.791, abs=0.002)
    assert adopted["woman A"].height == pytest.approx(1.658, abs=0.002)


@pytest.mark.slow
def test_an_official_model_of_smpl_s_faces_knows_its_sides(tmp_path, adopted, smpl_faces):
    body = adopted["man T"]
    regressor = np.zeros((N_JOINTS, 6890))
    for joint, position in enumerate(body.joints):
        regressor[joint, np.argsort(np.linalg.norm(body.vertices - position, axis=1))[:8]] = 1 / 8
    arrays = {
        "v_template": body.vertices @ Y_UP_TO_Z_UP,
        "f": smpl_faces.astype(np.uint32),
        "J_regressor": sparse.csc_matrix(regressor),
        "weights": body.weights,
        "kintree_table": np.array(
            [np.array(PARENTS).astype(np.uint32), np.arange(N_JOINTS, dtype=np.uint32)]
        ),
    }
    (tmp_path / "SMPL_MALE.pkl").write_bytes(pickle.dumps(arrays, 2))
    official = load_body(tmp_path / "SMPL_MALE.pkl")
    assert has_smpl_topology(official)
    np.testing.assert_array_equal(official.mirror, body.mirror)
    assert official.joints[JOINT_INDEX["left_wrist"], 0] > 0.5


@pytest.mark.slow
def test_a_t_pose_file_is_not_bent(adopted, shared_data, smpl_faces):
    vertices, polygons = read_mesh(shared_data / "smpl_body" / "human_man.obj")
    order = np.empty(6890, dtype=int)
    order[smpl_faces.ravel()] = polygons[:, :3].ravel()
    turned = vertices[order] @ Y_UP_TO_Z_UP.T
    offset = adopted["man T"].vertices - turned
    assert np.abs(offset - offset[0]).max() < 1e-9


@pytest.mark.slow
def test_an_a_pose_file_is_brought_to_the_t_pose(adopted, shared_data, smpl_faces):
    """The same two people stand in a T-pose in other files, which the A-pose files never saw."""
    for name, file in (("man A", "human_man.obj"), ("woman A", "human_woman.obj")):
        vertices, polygons = read_mesh(shared_data / "smpl_body" / file)
        order = np.empty(6890, dtype=int)
        order[smpl_faces.ravel()] = polygons[:, :3].ravel()
        truth = vertices[order] @ Y_UP_TO_Z_UP.T
        gap = adopted[name].vertices - truth
        gap = np.linalg.norm(gap - np.median(gap, axis=0), axis=1)
        assert gap.mean() < 0.0035
        assert np.percentile(gap, 95) < 0.009


@pytest.mark.slow
def test_weights_move_the_parts_that_smpl_s_move(adopted):
    """The published sensor vertices follow the joints their papers name."""
    for body in adopted.values():
        for vertex, joint in (
            (1961, "left_elbow"), (5424, "right_elbow"), (1176, "left_knee"), (4662, "right_knee"),
            (876, "left_hip"), (4362, "right_hip"), (411, "head"), (2445, "left_hand"), (3387, "left_ankle"),
        ):  # fmt: skip
            assert body.weights[vertex, JOINT_INDEX[joint]] > 0.5, (body.name, vertex)


def turned_shoulders(body, turns):
    """The body's vertices with rotation vectors, radians, at some joints, its median at the origin."""
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    for joint, turn in turns.items():
        rotations[0, JOINT_INDEX[joint]] = Rotation.from_rotvec(turn).as_matrix()
    posed = skin(body, skinning_transforms(body, Motion(rotations, body.joints[:1], 30)))[0]
    return posed - np.median(posed, axis=0)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "file"), [("man T", "m"), ("woman T", "f")])
def test_a_body_adopted_in_a_t_pose_can_take_the_a_pose(adopted, shared_data, name, file):
    """The A-pose file is the T-pose with both shoulders turned by 40 degrees and nothing else.

    Turned so, what is left is mostly the man's shoulder joints, which lie 16 and 10 mm nearer to
    the trunk than SMPL's; with the best turns of collars and shoulders the weights are left.
    """
    body = adopted[name]
    truth = read_mesh(shared_data / "smpl_body" / f"{file}_smpl_average_A40.obj")[0] @ Y_UP_TO_Z_UP.T
    joints = ("left_shoulder", "right_shoulder", "left_collar", "right_collar")
    known = np.zeros((4, 3))
    known[:2, 1] = np.radians([40, -40])

    def gap(turns):
        offset = turned_shoulders(body, dict(zip(joints, turns.reshape(4, 3), strict=True))) - truth
        return offset - np.median(offset, axis=0)

    found = least_squares(lambda turns: gap(turns)[::7].ravel(), known.ravel(), method="lm").x
    as_posed, as_found = (np.linalg.norm(gap(turns), axis=1) for turns in (known, found))
    assert as_posed.mean() < (0.0045 if file == "m" else 0.0009)
    assert as_found.mean() < 0.00087
    assert np.percentile(as_found, 95) < 0.0035


def test_smpl_s_shoulders_change_only_shoulders(bundled_body):
    """Rows stay shares, the two sides stay alike, and nothing below the ribs or past the elbow moves."""
    joints, weights = with_smpl_shoulders(bundled_body.vertices, bundled_body.joints, bundled_body.weights)
    np.testing.assert_allclose(weights.sum(axis=1), 1, atol=1e-12)
    assert weights.min() >= 0
    changed = np.abs(weights - bundled_body.weights).max(axis=1) > 1e-9
    shoulders = joints[[JOINT_INDEX["left_shoulder"], JOINT_INDEX["right_shoulder"]]]
    away = np.linalg.norm(bundled_body.vertices[:, None] - shoulders, axis=2).min(axis=1)
    assert 100 < changed.sum() < 1500
    assert away[changed].max() < 0.25
    moved = np.linalg.norm(joints - bundled_body.joints, axis=1)
    assert set(np.flatnonzero(moved)) == {JOINT_INDEX["left_shoulder"], JOINT_INDEX["right_shoulder"]}
    assert moved.max() < 0.02
    swapped = weights[bundled_body.mirror][:, list(MIRRORED_JOINTS)]
    np.testing.assert_allclose(swapped, weights, atol=1e-6)


@pytest.mark.slow
def test_registration_finds_the_rig_of_a_body_it_knows(bundled_body):
    """The target is the template itself, smaller and posed, so rig and weights are known."""
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    rotations[0, JOINT_INDEX["left_shoulder"]] = Rotation.from_rotvec([0, 0.6, 0]).as_matrix()
    rotations[0, JOINT_INDEX["right_shoulder"]] = Rotation.from_rotvec([0, -0.6, 0]).as_matrix()
    transforms = skinning_transforms(bundled_body, Motion(rotations, bundled_body.joints[:1], 30))
    target = 0.95 * skin(bundled_body, transforms)[0]
    marks = np.arange(0, len(target), 400)
    joints, weights, distance = register(bundled_body, target, bundled_body.faces, (marks, marks))
    assert distance.mean() < 0.0005
    wrong = np.abs(weights - bundled_body.weights).sum(axis=1) / 2
    assert wrong.mean() < 0.02
    shoulders = [JOINT_INDEX[f"{side}_shoulder"] for side in ("left", "right")]
    elbows = [JOINT_INDEX[f"{side}_elbow"] for side in ("left", "right")]
    np.testing.assert_allclose(joints[shoulders], 0.95 * bundled_body.joints[shoulders], atol=0.012)
    moved = bundled_body.joints[shoulders] + np.einsum(
        "jab,jb->ja", rotations[0, shoulders], bundled_body.joints[elbows] - bundled_body.joints[shoulders]
    )
    np.testing.assert_allclose(joints[elbows], 0.95 * moved, atol=0.012)


# --- convention


@settings(max_examples=15, deadline=None)
@given(st.floats(13, 80), st.floats(0, 70), st.floats(21, 90))
def test_posed_limbs_come_back_to_the_t_pose(bundled_body, lowered, bent, spread):
    """Posing by linear blend skinning and straightening are each other's inverse."""
    rotations = np.tile(np.eye(3), (1, N_JOINTS, 1, 1))
    elbow = bent if bent > 25 else 0  # less is taken for how someone is built
    for side, sign in (("left", 1), ("right", -1)):
        shoulder = Rotation.from_rotvec([0, sign * np.radians(lowered), 0])
        rotations[0, JOINT_INDEX[f"{side}_shoulder"]] = shoulder.as_matrix()
        forearm = Rotation.from_rotvec([0, 0, -sign * np.radians(elbow)])
        rotations[0, JOINT_INDEX[f"{side}_elbow"]] = forearm.as_matrix()
        thigh = Rotation.from_rotvec([0, -sign * np.radians(spread / 3 + 6), 0])
        rotations[0, JOINT_INDEX[f"{side}_hip"]] = thigh.as_matrix()
    motion = Motion(rotations, bundled_body.joints[:1], 30)
    transforms = skinning_transforms(bundled_body, motion)
    posed = skin(bundled_body, transforms)[0]
    joints = np.einsum("jab,jb->ja", transforms[0, :, :, :3], bundled_body.joints) + transforms[0, :, :, 3]
    vertices, straight = in_t_pose(posed, joints, bundled_body.weights, bundled_body)
    np.testing.assert_allclose(straight, bundled_body.joints, atol=1e-9)
    np.testing.assert_allclose(vertices, bundled_body.vertices, atol=1e-6)


def test_a_t_pose_stays_bit_for_bit(bundled_body):
    vertices, joints = in_t_pose(
        bundled_body.vertices, bundled_body.joints, bundled_body.weights, bundled_body
    )
    assert vertices is bundled_body.vertices
    assert joints is bundled_body.joints


@given(st.integers(0, 23), st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
def test_leaning_bodies_stand_along_the_file_s_axes(which, lean, aside):
    axes = Rotation.create_group("O").as_matrix()[which]
    left = axes.T @ np.array([1, aside, 0.0])
    up = axes.T @ np.array([0, lean, 1.0])
    np.testing.assert_allclose(to_axes(left, up), axes, atol=1e-12)


def test_bodies_askew_are_turned_by_their_own_axes():
    turn = Rotation.from_euler("xyz", [40, 35, 10], degrees=True).as_matrix()
    np.testing.assert_allclose(to_axes(turn.T @ [1.0, 0, 0], turn.T @ [0, 0, 1.0]), turn, atol=1e-12)


def test_units_are_told_by_height():
    assert [metres_per_unit(height) for height in (1.7, 170, 1700, 0.5)] == [1, 0.01, 0.001, 1]
    with pytest.raises(ValueError, match=r"expected 0\.4 to 2.5 metres"):
        metres_per_unit(17)
