"""A garment covers the patches that it passes over; its sensors are turned as those on the skin."""

import numpy as np
import pytest

from w2w.core.garments.cut import cut
from w2w.core.imu.cover import (
    FITTED,
    Cover,
    cover,
    cover_content,
    cover_sentence,
    covered,
    load_covers,
    save_covers,
    skinned_as,
    without_overlap,
)
from w2w.core.motion.skinning import patch_matrices
from w2w.core.patches.patches import sample_patches
from w2w.core.study.clip_files import WORK


@pytest.fixture(scope="module")
def patches(bundled_body):
    return sample_patches(bundled_body, n=96, seed=0)


@pytest.fixture(scope="module")
def covers(bundled_body, patches):
    return {
        kind: cover(cloth.vertices, cloth.faces, bundled_body, patches)
        for kind in ("tshirt", "trousers")
        for cloth in [cut(kind, bundled_body).cloth]
    }


def regions(patches, chosen):
    return {patches.regions[patch].split(" ", 1)[-1] for patch in chosen.patches}


def test_a_shirt_covers_the_chest_and_no_hand(covers, patches):
    shirt, trousers = (regions(patches, covers[kind]) for kind in ("tshirt", "trousers"))
    assert {"posterior scapula", "upper arm lateral"} <= shirt
    assert {"thigh front", "calf"} <= trousers
    bare = {"palm", "back of hand", "forearm dorsal", "sole", "scalp crown", "cheek", "instep"}
    assert not bare & (shirt | trousers)


@pytest.mark.slow
def test_the_skin_itself_is_covered_everywhere_by_its_own_triangles(bundled_body, patches):
    found = cover(bundled_body.vertices, bundled_body.faces, bundled_body, patches)
    assert found.patches.tolist() == list(range(96))
    same = (found.triangles == patches.triangles).all(axis=1)
    assert same.mean() > 0.95  # of triangles that are equally steady another may be chosen
    np.testing.assert_allclose(found.mounts[same], np.broadcast_to(np.eye(3), (same.sum(), 3, 3)), atol=1e-9)


def test_at_rest_sensors_are_turned_as_on_the_skin(covers, bundled_body, patches):
    cloth = cut("tshirt", bundled_body).cloth
    own = covers["tshirt"]
    matrices = own.matrices(cloth.vertices[own.triangles][None])[0]
    first, second, third = bundled_body.vertices[patches.triangles[own.patches]].transpose(1, 0, 2)
    across = second - first
    np.testing.assert_allclose(
        matrices[:, :3, 0], across / np.linalg.norm(across, axis=1)[:, None], atol=1e-9
    )
    normal = np.cross(across, third - first)
    np.testing.assert_allclose(
        matrices[:, :3, 2], normal / np.linalg.norm(normal, axis=1)[:, None], atol=1e-9
    )
    np.testing.assert_allclose(np.linalg.det(matrices[:, :3, :3]), 1)


def test_sensors_sit_over_their_patches(covers, bundled_body, patches):
    for kind, own in covers.items():
        cloth = cut(kind, bundled_body).cloth
        middle = cloth.vertices[own.triangles].mean(axis=1)
        away = np.linalg.norm(middle - bundled_body.vertices[patches.vertices[own.patches]], axis=1)
        assert away.max() < 0.09


def test_a_garment_that_faces_inward_is_turned_over(bundled_body, patches, covers):
    cloth = cut("tshirt", bundled_body).cloth
    found = cover(cloth.vertices, cloth.faces[:, ::-1], bundled_body, patches)
    np.testing.assert_array_equal(found.patches, covers["tshirt"].patches)


def test_a_garment_in_a_motion_is_its_skinned_self(bundled_body, patches, waving):
    cloth = cut("tshirt", bundled_body).cloth
    weighted = skinned_as(cloth.vertices, cloth.faces, bundled_body)
    np.testing.assert_allclose(weighted.weights.sum(axis=1), 1)
    own = cover(cloth.vertices, cloth.faces, bundled_body, patches)
    turned = patch_matrices(weighted, own.triangles, waving)[..., :3, :3] @ own.mounts
    on_skin = patch_matrices(bundled_body, patches.triangles[own.patches], waving)[..., :3, :3]
    cosine = (np.einsum("tnab,tnab->tn", turned, on_skin) - 1) / 2
    assert np.degrees(np.median(np.arccos(np.clip(cosine, -1, 1)))) < 10


def test_a_mesh_far_away_covers_nothing(bundled_body, patches):
    cloth = cut("tshirt", bundled_body).cloth
    assert len(cover(cloth.vertices + (3.0, 0, 0), cloth.faces, bundled_body, patches)) == 0
    assert len(cover(cloth.vertices, cloth.faces[:0], bundled_body, patches)) == 0


def test_the_outer_garment_has_the_patches_of_both(covers):
    outer, inner = without_overlap([covers["tshirt"], covers["trousers"]])
    np.testing.assert_array_equal(outer.patches, covers["tshirt"].patches)
    assert not set(inner.patches) & set(outer.patches)
    assert set(inner.patches) | set(outer.patches) == set(covers["tshirt"].patches) | set(
        covers["trousers"].patches
    )


def test_what_is_covered_can_be_saved_and_read(tmp_path, covers):
    save_covers(tmp_path / "garments.npz", covers, ["", "abc"])
    for name, own in load_covers(tmp_path / "garments.npz").items():
        for part in ("patches", "triangles", "mounts"):
            np.testing.assert_array_equal(getattr(own, part), getattr(covers[name], part))
    (tmp_path / "garments.npz").write_bytes(b"none")
    with pytest.raises(ValueError, match="does not say what garments cover"):
        load_covers(tmp_path / "garments.npz")


def test_it_names_the_patches_and_their_regions(tmp_path, bundled_body):
    patches = sample_patches(bundled_body, n=12)
    (tmp_path / WORK).mkdir()
    chosen = np.array([2, 5])
    own = Cover(chosen, np.zeros((2, 3), dtype=int), np.tile(np.eye(3), (2, 1, 1)))
    save_covers(tmp_path / FITTED, {"tshirt": own}, [""])
    content = cover_content(tmp_path, patches)
    regions = sorted({patches.regions[2], patches.regions[5]})
    assert content == {"garments": {"tshirt": {"patches": [2, 5], "regions": regions}}}
    assert covered(content) == {"tshirt": [2, 5]}
    sentence = cover_sentence(content, 12)
    assert sentence.startswith("Of 12 patches 2 on tshirt and 10 on the skin.")
    assert "not yet been checked against worn garments" in sentence


def test_where_nothing_is_worn_nothing_is_said():
    assert cover_sentence({}, 12) == ""
