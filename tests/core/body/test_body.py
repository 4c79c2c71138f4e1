# SPDX-License-Identifier: GPL-3.0-or-later
"""A body refuses what is not one, and comes back from its file unchanged."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.body.body import Body, first_turn


def test_round_trip(bundled_body, tmp_path):
    bundled_body.save(tmp_path / "body.npz")
    read = Body.load(tmp_path / "body.npz")
    np.testing.assert_array_equal(read.vertices, bundled_body.vertices)
    np.testing.assert_array_equal(read.faces, bundled_body.faces)
    np.testing.assert_allclose(read.weights, bundled_body.weights, atol=1e-6)
    assert read.name == bundled_body.name


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("vertices", np.zeros((5, 2)), "vertices must have shape"),
        ("faces", np.array([[0, 1, 99999]]), "outside"),
        ("faces", np.full((5, 3), np.nan), "faces name vertices outside"),
        ("mirror", np.full(6890, 6890), "mirror name vertices outside"),
        ("joints", np.zeros((23, 3)), "joints must have shape"),
        ("weights", np.ones((3, 24)), "weights must have shape"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_wrong_shapes_are_named(bundled_body, field, value, message):
    with pytest.raises(ValueError, match=message):
        replace(bundled_body, **{field: value})


def test_weights_must_sum_to_one(bundled_body):
    with pytest.raises(ValueError, match="sum to 1"):
        replace(bundled_body, weights=bundled_body.weights * 0.9)


def test_a_foreign_npz_is_refused(tmp_path):
    np.savez(tmp_path / "other.npz", something=np.zeros(3))
    with pytest.raises(ValueError, match="lacks"):
        Body.load(tmp_path / "other.npz")


def test_arrays_cannot_be_changed_by_accident(bundled_body):
    with pytest.raises(ValueError, match="read-only"):
        bundled_body.vertices[0] = 0


def test_bodies_with_the_same_arrays_are_equal(bundled_body):
    like = replace(bundled_body, vertices=bundled_body.vertices.copy())
    assert like == bundled_body
    assert hash(like) == hash(bundled_body)
    shifted = bundled_body.weights.copy()
    shifted[0] = np.roll(shifted[0], 1)
    assert replace(bundled_body, weights=shifted) != bundled_body
    assert replace(bundled_body, mirror=None) != bundled_body
    assert bundled_body != "body"
    assert Body.bundled() is Body.bundled()  # one object, so that what is known of it is found at once


def test_a_spot_is_first_looked_at_from_the_front_unless_the_body_hides_it_there(bundled_body, all_patches):
    turns = np.array([first_turn(bundled_body, vertex) for vertex in all_patches.vertices.tolist()])
    shares = {
        part: (np.cos(turns[[region.endswith(part) for region in all_patches.regions]]) < 0).mean()
        for part in ("sternum", "abdomen", "shin", " ear", "wrist volar", "sacrum", "spine", "knee back")
    }
    assert [*shares.values()] == [0, 0, 0, 0, 0, 1, 1, 1], shares
    ear = all_patches.regions.index("right ear")
    assert bundled_body.vertex_normals[all_patches.vertices[ear], 1] > 0.8  # leans away, and is seen
    assert -0.7 < turns[ear] < 0
    assert 0.5 < turns[all_patches.regions.index("left thigh lateral")] < 0.7


def test_a_body_is_near_its_like_in_single_precision(bundled_body):
    single = replace(bundled_body, vertices=bundled_body.vertices.astype(np.float32).astype(float))
    assert bundled_body.is_near(single, 1e-5)
    assert not bundled_body.is_near(replace(bundled_body, vertices=bundled_body.vertices + 0.001), 1e-5)
