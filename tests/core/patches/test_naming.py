# SPDX-License-Identifier: GPL-3.0-or-later
"""Places by name: the 11 placements and published sensor sites, on the bundled body and on SMPL's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.body.landmarks import SENSOR_SITES, has_smpl_topology
from w2w.core.body.regions import regions_of
from w2w.core.body.skeleton import JOINT_NAMES
from w2w.core.patches.naming import PLACEMENTS, placement_patches, region_centre, resolve
from w2w.core.patches.patches import PatchSet, sample_patches

SITES = {site.name: site for site in SENSOR_SITES}


@pytest.fixture(scope="module")
def patches(bundled_body) -> PatchSet:
    return sample_patches(bundled_body, mode="fast")


@pytest.fixture(scope="module")
def smpl_body(shared_data: Path) -> Body:
    """A real body in SMPL's topology, from its rigged FBX file."""
    bpy = pytest.importorskip("bpy")
    bpy.ops.wm.read_factory_settings(use_empty=True)
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
    assert sum(placement.common for placement in PLACEMENTS) == 8
    unusual = {placement.name for placement in PLACEMENTS if not placement.common}
    assert unusual == {"posterior scapula", "lower spine", "lateral oblique"}


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_eleven_placements_are_eleven_patches_near_their_regions(bundled_body, patches, side) -> None:
    found = placement_patches(bundled_body, patches, side)
    assert len(set(found.values())) == len(found) == 11
    for placement in PLACEMENTS:
        centre = bundled_body.vertices[region_centre(bundled_body, placement.on(side))]
        patch = bundled_body.vertices[patches.vertices[found[placement.name]]]
        assert np.linalg.norm(patch - centre) < 0.05
        assert found[placement.name] == resolve(
            f"{side} {placement.name}" if placement.sided else placement.name, bundled_body, patches
        )


def test_left_and_right_placements_are_on_their_sides(bundled_body, patches) -> None:
    for placement in PLACEMENTS:
        if placement.sided:
            left, right = (
                bundled_body.vertices[
                    patches.vertices[resolve(f"{s} {placement.name}", bundled_body, patches)]
                ]
                for s in ("left", "right")
            )
            assert left[0] > 0 > right[0]


def test_a_placement_without_side_is_the_left_one(bundled_body, patches) -> None:
    assert resolve("Wrist", bundled_body, patches) == resolve("left wrist", bundled_body, patches)


def test_words_and_patch_names_resolve(bundled_body, patches) -> None:
    assert resolve(patches.names[77], bundled_body, patches) == 77
    assert patches.regions[resolve("scapula right", bundled_body, patches)] == "right posterior scapula"
    assert "left knee" in patches.regions[resolve("left knee", bundled_body, patches)]


def test_an_unknown_place_is_met_with_suggestions(bundled_body, patches) -> None:
    with pytest.raises(ValueError, match=r'called "lft wirst"; did you mean .*left wrist'):
        resolve("lft wirst", bundled_body, patches)
    with pytest.raises(ValueError, match="no placement"):
        resolve("", bundled_body, patches)


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
