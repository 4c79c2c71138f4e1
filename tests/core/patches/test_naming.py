# SPDX-License-Identifier: GPL-3.0-or-later
"""Places by name on several builds, the patches that stand for them, and published sensor sites."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from w2w.core.adopt.smpl import load_body
from w2w.core.body.body import JOINT_INDEX, JOINT_NAMES, Body
from w2w.core.body.landmarks import SENSOR_SITES, has_smpl_topology
from w2w.core.body.regions import regions_of
from w2w.core.body.shapes import shaped
from w2w.core.patches.body_parts import PLACEMENTS
from w2w.core.patches.naming import place, resolve
from w2w.core.patches.own_placements import patches_at
from w2w.core.patches.patches import sample_patches
from w2w.core.patches.spots import Spot, vertex_at

SIDES = ("left", "right")
SITES = {site.name: site for site in SENSOR_SITES}


@pytest.fixture(scope="module")
def smpl_body(shared_data: Path) -> Body:
    """A real body in SMPL's topology, from its rigged FBX file."""
    bpy = pytest.importorskip("bpy")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.fbx_import(filepath=str(shared_data / "smpl_body" / "fixture_smplbody_rigged.fbx"))
    mesh = next(item for item in bpy.data.objects if item.type == "MESH")
    bones = next(item for item in bpy.data.objects if item.type == "ARMATURE").data.bones
    by_joint = [next(bone for bone in bones if _joint_name(bone.name) == name) for name in JOINT_NAMES]
    weights = np.zeros((len(mesh.data.vertices), len(JOINT_NAMES)))
    columns = {group.index: JOINT_NAMES.index(_joint_name(group.name)) for group in mesh.vertex_groups}
    for vertex in mesh.data.vertices:
        for group in vertex.groups:
            weights[vertex.index, columns[group.group]] = group.weight
    return Body(
        vertices=np.array([vertex.co[:] for vertex in mesh.data.vertices]),
        faces=np.load(shared_data / "smpl_body" / "smpl_faces_from_ccby.npy"),
        joints=np.array([bone.head_local[:] for bone in by_joint]),
        weights=weights / weights.sum(axis=1, keepdims=True),
    )


def _joint_name(bone: str) -> str:
    """`m_avg_L_Hip` is called left_hip here."""
    name = bone.removeprefix("m_avg_")
    for short, side in (("L_", "left_"), ("R_", "right_")):
        if name.startswith(short):
            name = side + name.removeprefix(short)
    return name.lower()


def test_there_are_eight_common_placements_and_three_unusual_ones() -> None:
    names = [placement.name for placement in PLACEMENTS]
    assert names[:8] == ["wrist", "upper arm", "chest", "waist", "pocket", "ankle", "foot", "ear"]
    assert names[8:] == ["posterior scapula", "lower spine", "lateral oblique"]


SMPL_BODIES = [pytest.param(f"SMPL {sex}", marks=pytest.mark.slow) for sex in ("male", "female")]
"""They take a quarter of a minute to adopt."""


@pytest.fixture(scope="module", params=["neutral", "heavy", *SMPL_BODIES])
def build(request, bundled_body, shared_data) -> Body:
    """Bodies of four builds, two of them of another topology and real people's average."""
    if request.param == "heavy":
        return shaped(bundled_body, weight=95.0)
    if request.param.startswith("SMPL"):
        sex = request.param.split()[1][0]
        return load_body(shared_data / "smpl_body" / f"{sex}_smpl_average_A40.obj")
    return bundled_body


def _joint(body: Body, name: str) -> np.ndarray:
    return body.joints[JOINT_INDEX[name]]


def _between(body: Body, vertex: int, start: str, end: str) -> float:
    """How far from one joint to the next a vertex lies."""
    bone = _joint(body, end) - _joint(body, start)
    return float((body.vertices[vertex] - _joint(body, start)) @ bone / (bone @ bone))


def _follows(body: Body, name: str, *joints: str) -> float:
    """By how much a sensor at a place follows some joints."""
    (triangle,) = patches_at(body, {"sensor": place(name, body)}).triangles
    return float(body.weights[triangle][:, [JOINT_INDEX[joint] for joint in joints]].sum(axis=1).mean())


@pytest.mark.later
@pytest.mark.parametrize("side", SIDES)
def test_a_watch_lies_on_the_back_of_the_wrist_and_follows_hand_and_forearm(build, side) -> None:
    vertex = place(f"{side} wrist dorsal", build)
    assert vertex == place(f"{side} wrist", build) == place(f"{side} watch", build)
    assert 0.95 < _between(build, vertex, f"{side}_elbow", f"{side}_wrist") < 1.02
    assert build.vertex_normals[vertex, 2] > 0.9  # the back of the hand is up in the T-pose
    assert 0.25 < _follows(build, f"{side} wrist", f"{side}_wrist", f"{side}_hand") < 0.6


@pytest.mark.later
@pytest.mark.parametrize("side", SIDES)
def test_the_instep_is_the_top_of_the_arch_and_does_not_follow_the_toes(build, side) -> None:
    vertex = place(f"{side} instep", build)
    assert vertex == place(f"{side} foot", build) == place(f"{side} shoe", build)
    assert 0.4 < _between(build, vertex, f"{side}_ankle", f"{side}_foot") < 0.65
    assert build.vertex_normals[vertex, 2] > 0.6
    assert _follows(build, f"{side} instep", f"{side}_foot") < 0.01
    assert _follows(build, f"{side} instep", f"{side}_ankle") > 0.9


def test_the_sacrum_is_eight_centimetres_above_the_hips(build) -> None:
    vertex = place("sacrum", build)
    hips = (_joint(build, "left_hip") + _joint(build, "right_hip")) / 2
    assert 0.06 < build.vertices[vertex, 2] - hips[2] < 0.1
    assert abs(build.vertices[vertex, 0] - hips[0]) < 0.01
    assert build.vertex_normals[vertex, 1] > 0.85
    assert _follows(build, "sacrum", "pelvis") > 0.9


def test_places_are_the_same_on_both_sides(build) -> None:
    for region in regions_of(build)[1]:
        if not region.startswith("left "):
            continue
        left, right = (place(region.replace("left", side), build) for side in SIDES)
        if build.mirror is not None:
            assert build.mirror[left] == right, region
    for one in PLACEMENTS:  # on people's average, to a centimetre or two
        left, right = (build.vertices[place(one.on(side), build)] for side in SIDES)
        middle = _joint(build, "left_hip")[0] + _joint(build, "right_hip")[0]
        assert np.linalg.norm([middle, 0, 0] + left * [-1, 1, 1] - right) < 0.025 or not one.sided


def test_round_a_limb_the_outside_is_meant_on_every_build(build) -> None:
    codes, names = regions_of(build)
    for words, region in {
        "left thigh": "left thigh lateral",
        "right knee": "right knee lateral",
        "left forearm": "left forearm dorsal",
        "scapula right": "right posterior scapula",
    }.items():
        assert names[codes[place(words, build)]] == region


def test_a_placement_without_side_is_the_left_one(bundled_body) -> None:
    assert place("Wrist", bundled_body) == place("left wrist", bundled_body)


def test_a_patch_s_own_name_means_that_patch(bundled_body, patches) -> None:
    assert resolve(patches.names[77], bundled_body, patches) == 77


@pytest.mark.filterwarnings("ignore:the nearest patch")
@pytest.mark.parametrize("n", [16, 48, 96])
def test_no_patch_stands_for_a_place_that_it_is_far_from(bundled_body, n) -> None:
    few = sample_patches(bundled_body, n)
    seen = set()
    for region in regions_of(bundled_body)[1]:
        if region in few.names:
            continue
        said = []
        vertex = place(region, bundled_body)
        patch = few.labels[vertex]
        away = 100 * np.linalg.norm(
            bundled_body.vertices[few.vertices[patch]] - bundled_body.vertices[vertex]
        )
        if away > 10:
            with pytest.raises(
                ValueError, match=rf"'{region}' is {away:.1f} cm away .* more than {n} patches"
            ):
                resolve(region, bundled_body, few, said.append)
        else:
            assert resolve(region, bundled_body, few, said.append) == patch
            assert len(said) == (away > 5)
            assert all(f"{away:.1f} cm away ({few.names[patch]})" in sentence for sentence in said)
        seen.add(int(away > 5) + int(away > 10))
    assert seen == ({0, 1, 2} if n < 96 else {0, 1})


def test_python_is_warned_of_a_patch_that_is_not_near(bundled_body) -> None:
    few = sample_patches(bundled_body, 96)
    with pytest.warns(UserWarning, match="the nearest patch to 'chest' is .* cm away"):
        resolve("chest", bundled_body, few)


def test_an_unknown_place_is_met_with_suggestions(bundled_body, patches) -> None:
    with pytest.raises(ValueError, match=r'called "lft wirst"; did you mean .*left wrist'):
        resolve("lft wirst", bundled_body, patches)
    with pytest.raises(ValueError, match="no placement"):
        place("", bundled_body)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("TransPose left forearm", "left wrist dorsal"),
        ("IMUPoser right forearm", "right wrist dorsal"),
        ("DIP left lower leg", "left lower leg lateral"),
        ("PNP right lower leg", "right"),
        ("MobilePoser left thigh", "left thigh front"),
        ("DIP head", "scalp crown"),
        ("LIP upper chest", "sternum"),
        ("PIP pelvis", "lower spine"),
    ],
)
def test_sites_lie_on_the_bundled_body_where_the_papers_put_them(bundled_body, name, words) -> None:
    codes, names = regions_of(bundled_body)
    assert words in names[codes[SITES[name].vertex(bundled_body)]]


def test_sites_resolve_by_name(bundled_body, patches) -> None:
    patch = resolve("transpose LEFT forearm", bundled_body, patches)
    assert patch == patches.labels[SITES["TransPose left forearm"].vertex(bundled_body)]


def test_the_bundled_body_is_not_taken_for_smpl(bundled_body) -> None:
    assert not has_smpl_topology(bundled_body)


def test_sites_are_the_published_vertices_on_smpl(smpl_body) -> None:
    assert has_smpl_topology(smpl_body)
    assert [SITES[f"IMUPoser {place}"].vertex(smpl_body) for place in ("left forearm", "head")] == [1961, 411]
    shuffled = np.random.default_rng(0).permutation(smpl_body.faces)
    assert has_smpl_topology(replace(smpl_body, faces=np.roll(shuffled, 1, axis=1)))


def test_the_description_of_every_site_finds_its_published_vertex_on_smpl(smpl_body) -> None:
    """Without knowing the topology, within one edge (15 mm) of the vertex the papers name."""
    disguised = replace(smpl_body, faces=smpl_body.faces[:, ::-1])
    assert not has_smpl_topology(disguised)
    for site in SENSOR_SITES:
        found = smpl_body.vertices[site.vertex(disguised)]
        assert np.linalg.norm(found - smpl_body.vertices[site.smpl_vertex]) < 0.015


def test_smpl_has_the_same_regions_as_the_bundled_body(bundled_body, smpl_body) -> None:
    assert set(regions_of(smpl_body)[1]) == set(regions_of(bundled_body)[1])


@pytest.mark.parametrize(
    ("vertex", "region"),
    [
        (1961, "left wrist dorsal"),
        (5424, "right wrist dorsal"),
        (876, "left thigh front"),
        (4362, "right thigh front"),
        (1096, "left lower leg lateral"),
        (411, "scalp crown"),
        (3021, "lower spine"),
        (3059, "sternum"),
        # landmarks of the smplx package's vertex_ids
        (332, "nose"),
        (2800, "left eye"),
        (6260, "right eye"),
        (583, "left ear"),
        (4071, "right ear"),
        (2746, "left thumb"),
        (2319, "left index finger"),
        (2445, "left middle finger"),
        (2556, "left ring finger"),
        (2673, "left little finger"),
        (6191, "right thumb"),
        (5782, "right index finger"),
        (6133, "right little finger"),
        (3216, "left toes"),
        (3387, "left heel"),
        (6624, "right toes"),
        (6787, "right heel"),
    ],
)
def test_well_known_smpl_vertices_have_the_right_regions(smpl_body, vertex, region) -> None:
    codes, names = regions_of(smpl_body)
    assert names[codes[vertex]] == region


def test_a_spot_by_a_tape_is_a_place(bundled_body):
    assert place("Left forearm 85%  50%", bundled_body) == vertex_at(
        bundled_body, Spot("left forearm", 85, 50)
    )
    with pytest.raises(ValueError, match="no segment is called"):
        place("left tail 85% 50%", bundled_body)
