# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches at placements of one's own: where they lie, what they are called, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import Synthesis
from w2w.core.imu.virtual import record_motion
from w2w.core.patches.carriers import random_poses
from w2w.core.patches.naming import resolve
from w2w.core.patches.own_placements import patches_at
from w2w.core.patches.patches import PatchSet, sample_patches


def test_placements_keep_their_names_order_and_vertices(bundled_body):
    near = bundled_body.vertices[2000] + [0.0, 0.0, 1e-4]
    patches = patches_at(bundled_body, {" Strap  pod": 1234, "ring": near, "third": np.int64(77)})
    assert patches.names == ("Strap pod", "ring", "third")
    assert patches.vertices.tolist() == [1234, 2000, 77]
    assert resolve("strap POD", bundled_body, patches) == 0
    np.testing.assert_array_equal(patches.labels[patches.vertices], [0, 1, 2])


def test_they_are_the_patches_that_sampling_makes_of_the_same_vertices(bundled_body):
    sampled = sample_patches(bundled_body, 24, seed=3, mode="fast")
    own = patches_at(bundled_body, {f"p{n}": int(vertex) for n, vertex in enumerate(sampled.vertices)})
    np.testing.assert_array_equal(own.triangles, sampled.triangles)
    np.testing.assert_array_equal(own.labels, sampled.labels)
    assert own.regions == sampled.regions
    assert (own.interpolation != sampled.interpolation).nnz == 0
    motion = random_poses(90, 4)
    signals = [
        record_motion(bundled_body, p, motion, Synthesis(), SensorModel(), 0).acc for p in (own, sampled)
    ]
    np.testing.assert_array_equal(*signals)


def test_a_file_keeps_their_names(bundled_body, tmp_path):
    patches_at(bundled_body, {"strap pod": 1234, "Größe": 5}).save(tmp_path / "own.npz")
    assert PatchSet.load(tmp_path / "own.npz").names == ("strap pod", "Größe")


HEAD = "at most 5 cm are allowed: positions are in metres on the body at rest"


@pytest.mark.parametrize(
    ("placements", "sentence"),
    [
        ({}, "no placement is given"),
        ({" ": 3}, "a placement has an empty name"),
        ({"Ring": 3, "ring ": 4}, "two placements are called 'ring'"),
        ({"pod": 6890}, "'pod' is at vertex 6890, which .* does not have: .* numbered from 0 to 6889"),
        ({"pod": -1}, "'pod' is at vertex -1"),
        ({"pod": (0, 0, 3.0)}, rf"'pod' lies 1\d\d\.\d cm from the skin, and {HEAD}"),
        (
            {"pod": (0, 0)},
            r"'pod' needs the number of a vertex or a position \(x, y, z\) in metres, not \(0, 0\)",
        ),
        ({"pod": (0, 0, np.nan)}, "'pod' needs the number"),
        ({"pod": "wrist"}, "'pod' needs the number of a vertex .*not 'wrist'"),
        ({"pod": True}, "'pod' needs the number"),
        ({"pod": 1.5}, "'pod' needs the number"),
        ({"pod": 12, "ring": 4, "cuff": 12}, "'pod' and 'cuff' are both at vertex 12: leave one of them out"),
    ],
)
def test_what_cannot_be_placed_is_said(bundled_body, placements, sentence):
    with pytest.raises(ValueError, match=sentence):
        patches_at(bundled_body, placements)


def test_every_piece_of_a_body_needs_a_placement(bundled_body):
    n = len(bundled_body.vertices)
    twice = replace(
        bundled_body,
        vertices=np.concatenate([bundled_body.vertices, bundled_body.vertices + [3.0, 0, 0]]),
        faces=np.concatenate([bundled_body.faces, bundled_body.faces + n]),
        weights=np.concatenate([bundled_body.weights] * 2),
        mirror=None,
    )
    with pytest.raises(ValueError, match="of 2 separate pieces: each needs a placement"):
        patches_at(twice, {"pod": 5})
