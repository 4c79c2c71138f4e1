# SPDX-License-Identifier: GPL-3.0-or-later
"""Body regions: complete, in one piece, alike on both sides, and right at landmarks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from w2w.core.body.body import JOINT_INDEX, Body
from w2w.core.body.regions import regions_of
from w2w.core.body.shapes import shaped

FINGERS = ("thumb", "index finger", "middle finger", "ring finger", "little finger")
LIMB_SIDES = ("front", "back", "lateral", "medial")
HAND_SIDES = ("dorsal", "volar", "thumb side", "little finger side")

PAIRED = (
    *(f"{part} {side}" for part in ("upper arm", "elbow", "thigh", "knee", "ankle") for side in LIMB_SIDES),
    *(f"{part} {side}" for part in ("forearm", "wrist") for side in HAND_SIDES),
    *FINGERS,
    *("shoulder front", "shoulder back", "shoulder lateral", "shoulder top", "armpit"),
    *("back of hand", "palm", "hand thumb side", "hand little finger side"),
    *("shin", "calf", "lower leg lateral", "lower leg medial", "front pocket"),
    *("heel", "sole", "toes", "instep", "foot lateral", "foot medial"),
    *("chest", "collarbone", "side ribs", "front ribs", "abdomen", "lateral oblique", "hip", "front hip"),
    *("posterior scapula", "middle back", "lower back", "buttock"),
    *("ear", "behind ear", "temple", "eye", "cheek", "jaw", "side of head", "neck"),
)
SINGLE = (
    *("sternum", "upper abdomen", "navel", "lower abdomen", "groin"),
    *("upper spine", "middle spine", "lower spine", "sacrum"),
    *("scalp crown", "forehead", "nose", "mouth", "chin", "throat", "nape", "back of head"),
)
EXPECTED = {*SINGLE, *(f"{side} {name}" for name in PAIRED for side in ("left", "right"))}


def region_at(body: Body, vertex: int) -> str:
    codes, names = regions_of(body)
    return names[codes[vertex]]


def outermost(body: Body, direction: tuple[float, float, float], among: np.ndarray | None = None) -> int:
    """Vertex farthest in a direction."""
    reach = body.vertices @ np.array(direction, dtype=float)
    return int(np.argmax(reach if among is None else np.where(among, reach, -np.inf)))


def skin_from(body: Body, point: np.ndarray, direction: tuple[float, float, float]) -> int:
    """Vertex where a ray from inside the body first comes out: near the ray and not far ahead."""
    spoke = body.vertices - point
    ahead = spoke @ np.array(direction, dtype=float)
    aside = np.linalg.norm(spoke - ahead[:, None] * np.array(direction, dtype=float), axis=1)
    return int(np.argmin(np.where(ahead > 0, aside + 0.2 * ahead, np.inf)))


def joint(body: Body, name: str) -> np.ndarray:
    return body.joints[JOINT_INDEX[name]]


def between(body: Body, start: str, end: str, fraction: float) -> np.ndarray:
    return joint(body, start) + fraction * (joint(body, end) - joint(body, start))


def test_every_region_a_designer_asks_for_exists(bundled_body) -> None:
    assert set(regions_of(bundled_body)[1]) == EXPECTED


def test_every_vertex_belongs_to_a_region_and_every_region_has_vertices(bundled_body) -> None:
    codes, names = regions_of(bundled_body)
    assert codes.shape == (len(bundled_body.vertices),)
    np.testing.assert_array_equal(np.unique(codes), np.arange(len(names)))


def test_every_region_is_one_piece(bundled_body) -> None:
    codes, names = regions_of(bundled_body)
    faces = bundled_body.faces
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    inside = edges[codes[edges[:, 0]] == codes[edges[:, 1]]]
    graph = coo_matrix((np.ones(len(inside)), inside.T), shape=(len(codes), len(codes)))
    assert connected_components(graph, directed=False)[0] == len(names)


def mirrored_region(name: str) -> str:
    side, _, spot = name.partition(" ")
    return {"left": f"right {spot}", "right": f"left {spot}"}.get(side, name)


def test_left_and_right_mirror_each_other(bundled_body) -> None:
    codes, names = regions_of(bundled_body)
    mirror = bundled_body.mirror
    for vertex in np.flatnonzero(mirror != np.arange(len(mirror))):
        assert names[codes[mirror[vertex]]] == mirrored_region(names[codes[vertex]])


def test_the_midline_belongs_to_neither_side(bundled_body) -> None:
    middle = np.flatnonzero(bundled_body.mirror == np.arange(len(bundled_body.mirror)))
    sided = [region_at(bundled_body, v) for v in middle if region_at(bundled_body, v) != "groin"]
    assert not [name for name in sided if "left" in name or "right" in name]


def test_left_is_where_x_is_positive(bundled_body) -> None:
    codes, names = regions_of(bundled_body)
    for code, name in enumerate(names):
        x = bundled_body.vertices[codes == code, 0].mean()
        assert not name.startswith("left") or x > 0
        assert not name.startswith("right") or x < 0


def test_extreme_points_have_the_names_they_should(bundled_body) -> None:
    body = bundled_body
    head = body.weights[:, JOINT_INDEX["head"]] > 0.5
    low = body.vertices[:, 2] < 0.05
    left = body.vertices[:, 0] > 0
    assert region_at(body, outermost(body, (0, 0, 1))) == "scalp crown"
    assert region_at(body, outermost(body, (0, -1, 0), head)) == "nose"
    assert region_at(body, outermost(body, (0, 1, 0), head)) == "back of head"
    assert region_at(body, outermost(body, (1, 0, 0), head)) == "left ear"
    assert region_at(body, outermost(body, (1, 0, 0))) == "left middle finger"
    assert region_at(body, outermost(body, (-1, 0, 0))) == "right middle finger"
    assert region_at(body, outermost(body, (0, -1, 0), low & left)) == "left toes"
    assert region_at(body, outermost(body, (0, 1, 0), low & left)) == "left heel"
    assert region_at(body, outermost(body, (0, -1, 0), body.vertices[:, 0] > 0.7)) == "left thumb"


@pytest.mark.parametrize(
    ("start", "end", "fraction", "direction", "region"),
    [
        ("left_elbow", "left_wrist", 0.92, (0, 0, 1), "left wrist dorsal"),
        ("left_elbow", "left_wrist", 0.92, (0, 0, -1), "left wrist volar"),
        ("right_elbow", "right_wrist", 0.92, (0, -1, 0), "right wrist thumb side"),
        ("right_elbow", "right_wrist", 0.92, (0, 1, 0), "right wrist little finger side"),
        ("left_elbow", "left_wrist", 0.5, (0, 0, 1), "left forearm dorsal"),
        ("right_shoulder", "right_elbow", 0.5, (0, -1, 0), "right upper arm front"),
        ("right_shoulder", "right_elbow", 0.5, (0, 0, 1), "right upper arm lateral"),
        ("left_shoulder", "left_elbow", 1.0, (0, 1, 0), "left elbow back"),
        ("left_hip", "left_knee", 0.5, (0, -1, 0), "left thigh front"),
        ("left_hip", "left_knee", 0.5, (1, 0, 0), "left thigh lateral"),
        ("right_hip", "right_knee", 0.5, (1, 0, 0), "right thigh medial"),
        ("left_hip", "left_knee", 1.0, (0, -1, 0), "left knee front"),
        ("right_knee", "right_ankle", 0.4, (0, -1, 0), "right shin"),
        ("right_knee", "right_ankle", 0.4, (0, 1, 0), "right calf"),
        ("left_knee", "left_ankle", 0.95, (1, 0, 0), "left ankle lateral"),
        ("right_knee", "right_ankle", 0.95, (1, 0, 0), "right ankle medial"),
        ("left_ankle", "left_foot", 0.6, (0, 0, 1), "left instep"),
        ("left_ankle", "left_foot", 0.5, (0, 0, -1), "left sole"),
        ("spine2", "spine3", 1.0, (0, -1, 0), "sternum"),
        ("spine2", "spine3", 1.0, (0, 1, 0), "upper spine"),
        ("pelvis", "spine1", 0.7, (0, 1, 0), "lower spine"),
        ("pelvis", "spine1", 0.0, (0, 1, 0), "sacrum"),
        ("neck", "head", 0.5, (0, 1, 0), "nape"),
    ],
)
def test_landmarks_have_the_names_they_should(bundled_body, start, end, fraction, direction, region) -> None:
    point = between(bundled_body, start, end, fraction)
    assert region_at(bundled_body, skin_from(bundled_body, point, direction)) == region


def test_scapula_lower_back_and_pocket_are_where_anatomy_puts_them(bundled_body) -> None:
    body = bundled_body
    beside_spine = between(body, "spine2", "spine3", 1.0) + [0.1, 0, 0]
    assert region_at(body, skin_from(body, beside_spine, (0, 1, 0))) == "left posterior scapula"
    small_of_back = between(body, "pelvis", "spine1", 0.9) + [-0.07, 0, 0]
    assert region_at(body, skin_from(body, small_of_back, (0, 1, 0))) == "right lower back"
    waist = between(body, "pelvis", "spine1", 1.0) + [0, -0.03, 0]
    assert region_at(body, skin_from(body, waist, (-1, 0, 0))) == "right lateral oblique"
    pocket = between(body, "left_hip", "left_knee", 0.12)
    assert region_at(body, skin_from(body, pocket, (0.7071, -0.7071, 0))) == "left front pocket"


def test_fingers_lie_side_by_side_from_thumb_to_little_finger(bundled_body) -> None:
    codes, names = regions_of(bundled_body)
    depth = [bundled_body.vertices[codes == names.index(f"left {finger}"), 1].mean() for finger in FINGERS]
    assert (np.diff(depth) > 0.01).all()


def test_fingers_that_cannot_be_told_apart_are_one_region(bundled_body, monkeypatch) -> None:
    monkeypatch.setattr("w2w.core.body.region_names.FINGER_PROMINENCE", 0.9)
    codes, names = regions_of(replace(bundled_body, name="mittens"))
    assert EXPECTED - set(names) == {f"{side} {finger}" for side in ("left", "right") for finger in FINGERS}
    x = bundled_body.vertices[:, 0]
    fingers = codes == names.index("left fingers")
    assert x[fingers].max() == x.max()
    assert x[fingers].min() > joint(bundled_body, "left_hand")[0]


def test_regions_do_not_depend_on_size_or_place(bundled_body) -> None:
    body = bundled_body
    child = Body(0.6 * body.vertices, body.faces, 0.6 * body.joints, body.weights)
    codes, names = regions_of(child)
    assert names == regions_of(body)[1]
    assert (codes == regions_of(body)[0]).mean() > 0.999


@pytest.mark.parametrize("stretch", [(1.25, 1.25, 1), (1, 1.4, 1), (0.85, 0.85, 1), (1, 1, 1.2)])
def test_stout_and_slender_bodies_have_all_regions(bundled_body, stretch) -> None:
    body = bundled_body
    other = Body(body.vertices * stretch, body.faces, body.joints * stretch, body.weights)
    assert set(regions_of(other)[1]) == EXPECTED


@pytest.mark.parametrize(
    "shape", [{"gender": -1, "height": 1.5, "weight": 45}, {"gender": 1, "height": 1.95, "weight": 120}]
)
def test_women_and_men_of_any_build_have_the_same_regions_in_the_same_places(bundled_body, shape) -> None:
    other = shaped(bundled_body, **shape)
    assert set(regions_of(other)[1]) == EXPECTED
    names, neutral = (np.array(regions_of(body)[1])[regions_of(body)[0]] for body in (other, bundled_body))
    assert (names == neutral).mean() > 0.88
