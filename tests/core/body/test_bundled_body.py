# SPDX-License-Identifier: GPL-3.0-or-later
"""The shipped body has the mesh, the pose and the weights that are asked of it, and can be made again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from tools.make_body import quality
from tools.make_body.makehuman import CACHE, WHEEL_NAME
from w2w.core.body.body import BUNDLED_BODY, JOINT_INDEX, JOINT_NAMES, MIRRORED_JOINTS, TEMPLATES, Body
from w2w.core.body.shapes import volume

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
CUBE_FACES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip


@pytest.fixture(scope="module")
def figures(bundled_body: Body) -> quality.Figures:
    return quality.measure(bundled_body)


@pytest.fixture(scope="module")
def wheel() -> Path:
    """The wheel that the body is made from; never downloaded by a test."""
    path = CACHE / WHEEL_NAME
    if not path.is_file():
        pytest.skip(f"{path} is not here: `python -m tools.make_body` downloads it")
    return path


# The measures themselves, on shapes whose answers are known.


def test_measures_of_a_cube():
    assert volume(CUBE, CUBE_FACES) == pytest.approx(1)
    assert quality.is_closed(CUBE_FACES)
    assert not quality.is_closed(CUBE_FACES[1:])
    assert not quality.is_closed(np.concatenate([CUBE_FACES[1:], CUBE_FACES[:1, ::-1]]))
    assert np.rad2deg(quality.smallest_angles(CUBE, CUBE_FACES)) == pytest.approx(45)
    assert quality.smallest_heights(CUBE, CUBE_FACES) == pytest.approx(np.sqrt(0.5))
    assert len(quality.unique_edges(CUBE_FACES)) == 18


@pytest.mark.parametrize(
    ("shift", "n_pierced"), [((0.5, 0.4, 0.3), 12), ((2.0, 0.0, 0.0), 0), ((0.3, 0.2, 0.1), 12)]
)
def test_two_cubes_pierce_each_other_only_where_they_overlap(shift, n_pierced):
    points = np.concatenate([CUBE, CUBE + shift])
    faces = np.concatenate([CUBE_FACES, CUBE_FACES + 8])
    assert len(quality.self_intersections(points, faces)) == n_pierced
    assert quality.count_components(faces, 16) == 2


def test_a_fold_between_faces_that_share_a_vertex_is_found():
    fan = np.array([[0, 0, 0], [1, -1, 0], [1, 1, 0], [2, 0, -1], [0.5, 0, 1]], dtype=float)
    assert len(quality.self_intersections(fan, np.array([[0, 1, 2], [0, 3, 4]]))) == 2


# The mesh.


def test_counts_are_those_of_smpl(figures):
    assert (figures.n_vertices, figures.n_faces) == (6890, 13776)


def test_mesh_is_one_closed_surface_without_handles(figures):
    assert figures.closed
    assert figures.n_components == 1
    assert figures.euler_characteristic == 2
    assert figures.volume > 0.05


def test_mesh_does_not_cut_itself(figures):
    assert figures.self_intersecting_faces == 0


def test_triangles_are_near_equilateral(figures):
    assert figures.min_angle_median >= 50
    assert figures.min_angle_p5 >= 38
    assert figures.min_angle_lowest >= 10
    assert figures.max_valence <= 8
    assert figures.faces_4mm_high >= 0.95


def test_body_is_its_own_mirror_image(figures, bundled_body):
    assert figures.mirror_error < 1e-9
    flipped = bundled_body.weights[bundled_body.mirror][:, list(MIRRORED_JOINTS)]
    np.testing.assert_allclose(flipped, bundled_body.weights, atol=1e-7)


def test_mirror_error_sees_a_moved_vertex_and_a_wrong_map(bundled_body):
    moved = bundled_body.vertices.copy()
    moved[moved[:, 0].argmax()] += [0, 0, 0.001]
    args = (bundled_body.faces, bundled_body.joints, bundled_body.weights)
    assert quality.mirror_error(Body(moved, *args, mirror=bundled_body.mirror)) == pytest.approx(0.001)
    wrong = bundled_body.mirror.copy()
    wrong[[0, bundled_body.mirror[0]]] = [1, 1]
    assert quality.mirror_error(Body(bundled_body.vertices, *args, mirror=wrong)) == np.inf


@pytest.mark.parametrize("pose", list(quality.POSES))
def test_posed_volume_stays_within_5_percent(figures, pose):
    assert abs(figures.volume_change[pose]) <= 0.05


@pytest.mark.parametrize(
    ("joint", "reach", "longest"), [("wrist", 0.04, 0.012), ("ankle", 0.04, 0.014), ("hand", 0.09, 0.010)]
)
def test_mesh_is_fine_where_straps_and_rings_are_worn(bundled_body, joint, reach, longest):
    faces, points = bundled_body.faces, bundled_body.vertices
    near = np.linalg.norm(points - bundled_body.joints[JOINT_INDEX[f"left_{joint}"]], axis=1) < reach
    corners = points[faces[near[faces].all(axis=1)]]
    edges = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    assert np.median(edges) <= longest


def test_ear_scalp_and_waist_hold_triangles_for_a_sensor(bundled_body):
    centres = bundled_body.vertices[bundled_body.faces].mean(axis=1)
    high = quality.smallest_heights(bundled_body.vertices, bundled_body.faces) >= 0.004
    head = bundled_body.joints[JOINT_INDEX["head"]]
    ear = centres[:, 0] > 0.9 * np.abs(centres[centres[:, 2] > head[2], 0]).max()
    assert (high & ear & (centres[:, 2] > head[2] - 0.05) & (centres[:, 2] < head[2] + 0.05)).sum() >= 30
    assert (high & (centres[:, 2] > bundled_body.height - 0.08)).sum() >= 150
    waist = np.abs(centres[:, 2] - bundled_body.joints[JOINT_INDEX["spine1"], 2]) < 0.03
    assert (high & waist).sum() >= 100


# The pose.


def test_body_stands_on_the_floor_at_an_adults_height(bundled_body):
    assert bundled_body.vertices[:, 2].min() == 0
    assert 1.70 <= bundled_body.height <= 1.75


def test_arms_point_sideways_with_palms_down_and_legs_down(bundled_body):
    at = dict(zip(JOINT_NAMES, bundled_body.joints, strict=True))
    arm = at["left_wrist"] - at["left_shoulder"]
    assert arm[0] > 0.45
    assert np.abs(arm[1:]).max() < 1e-6
    hand = bundled_body.weights[:, JOINT_INDEX["left_hand"]] > 0.9
    assert np.ptp(bundled_body.vertices[hand, 1]) > 2 * np.ptp(bundled_body.vertices[hand, 2])
    thumb = bundled_body.vertices[bundled_body.weights[:, JOINT_INDEX["left_wrist"]] > 0.9, 1].argmin()
    assert bundled_body.vertices[bundled_body.weights[:, JOINT_INDEX["left_wrist"]] > 0.9][thumb, 1] < -0.05
    leg = at["left_ankle"] - at["left_hip"]
    assert np.rad2deg(np.arccos(-leg[2] / np.linalg.norm(leg))) < 6
    knee = at["left_knee"] - at["left_hip"]
    assert np.linalg.norm(np.cross(leg, knee)) < 1e-6


def test_body_faces_minus_y(bundled_body):
    at = dict(zip(JOINT_NAMES, bundled_body.joints, strict=True))
    assert at["left_foot"][1] < at["left_ankle"][1] - 0.05
    head = bundled_body.vertices[bundled_body.weights[:, JOINT_INDEX["head"]] > 0.9]
    nose = head[head[:, 1].argmin()]
    assert nose[0] == pytest.approx(0, abs=1e-9)


def winding_number(point: np.ndarray, body: Body) -> float:
    """How often the surface goes round a point (van Oosterom and Strackee 1983): 1 inside, 0 outside."""
    a, b, c = (body.vertices[body.faces] - point).transpose(1, 0, 2)
    la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    numerator = np.einsum("fa,fa->f", a, np.cross(b, c))
    dots = [np.einsum("fa,fa->f", p, q) for p, q in ((a, b), (b, c), (c, a))]
    denominator = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    return float(np.arctan2(numerator, denominator).sum() / (2 * np.pi))


def test_every_joint_lies_inside(bundled_body):
    inside = [winding_number(joint, bundled_body) for joint in bundled_body.joints]
    np.testing.assert_allclose(inside, 1, atol=1e-6)


# The weights.


def test_at_most_four_joints_hold_a_vertex(bundled_body):
    assert (bundled_body.weights > 0).sum(axis=1).max() <= 4


def test_weights_change_smoothly(bundled_body):
    edges = quality.unique_edges(bundled_body.faces)
    lengths = np.linalg.norm(np.diff(bundled_body.vertices[edges], axis=1)[:, 0], axis=1)
    change = np.abs(np.diff(bundled_body.weights[edges], axis=1)[:, 0]).max(axis=1)
    assert (change / lengths).max() < 50  # from nothing to all takes at least two centimetres


def test_every_joint_holds_one_connected_part(bundled_body):
    every = quality.unique_edges(bundled_body.faces)
    for joint, name in enumerate(JOINT_NAMES):
        held = bundled_body.weights[:, joint] > 0.05
        edges = every[held[every].all(axis=1)]
        graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(len(held), len(held)))
        labels = connected_components(graph, directed=False)[1]
        assert len(np.unique(labels[held])) == 1, name


# The making of it.


@pytest.mark.slow
def test_made_again_it_has_the_same_bytes(wheel, tmp_path, monkeypatch):
    pytest.importorskip("igl", reason="building the body needs libigl")
    from tools.make_body import __main__ as script

    monkeypatch.setattr("sys.argv", ["make_body", "--wheel", str(wheel), "--out", str(tmp_path)])
    script.main()
    assert (tmp_path / "body.npz").read_bytes() == BUNDLED_BODY.read_bytes()
    assert (tmp_path / "shapes.npz").read_bytes() == (TEMPLATES / "shapes.npz").read_bytes()


def test_vertices_lie_within_a_millimetre_of_makehumans_surface(wheel, bundled_body):
    igl = pytest.importorskip("igl", reason="distances to the source need libigl")
    from tools.make_body.makehuman import Source
    from tools.make_body.pipeline import pose_source

    posed = pose_source(Source(wheel))
    floor = posed.joints[0] - bundled_body.joints[0]
    squared, _, _ = igl.point_mesh_squared_distance(
        bundled_body.vertices + floor, posed.vertices, np.ascontiguousarray(posed.triangles)
    )
    assert np.sqrt(squared.max()) < 0.001
    assert quality.is_closed(posed.triangles)


def test_a_wheel_that_is_not_there_is_named(tmp_path):
    from tools.make_body.makehuman import find_wheel

    with pytest.raises(FileNotFoundError, match=r"missing\.whl"):
        find_wheel(tmp_path / "missing.whl")
