# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches at placements of one's own: where they lie, what they are called, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import Synthesis
from w2w.core.imu.virtual import record_motion
from w2w.core.patches.body_parts import find_patches
from w2w.core.patches.carriers import random_poses
from w2w.core.patches.naming import resolve
from w2w.core.patches.own_placements import patches_at, placement_vertices, read_placements, with_placements
from w2w.core.patches.patches import PatchSet, sample_patches
from w2w.core.patches.spots import Spot, vertex_at


def test_placements_keep_their_names_order_and_vertices(bundled_body):
    near = bundled_body.vertices[2000] + [0.0, 0.0, 1e-4]
    patches = patches_at(bundled_body, {" Strap  pod": 1234, "ring": near, "third": np.int64(77)})
    assert patches.names == ("Strap pod", "ring", "third")
    assert patches.vertices.tolist() == [1234, 2000, 77]
    assert resolve("strap POD", bundled_body, patches) == 0
    np.testing.assert_array_equal(patches.labels[patches.vertices], [0, 1, 2])


@pytest.mark.later
def test_they_are_the_patches_that_sampling_makes_of_the_same_vertices(bundled_body):
    sampled = sample_patches(bundled_body, 24, seed=3)
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
        ({"pod": "wrist"}, "'wrist' is no spot: write a segment"),
        ({"pod": True}, "'pod' needs the number"),
        ({"pod": 1.5}, "'pod' needs the number"),
        ({"pod": 12, "ring": 4, "cuff": 12}, "'pod' and 'cuff' are both at vertex 12: leave one of them out"),
    ],
)
def test_what_cannot_be_placed_is_said(bundled_body, placements, sentence):
    with pytest.raises(ValueError, match=sentence):
        patches_at(bundled_body, placements)


@pytest.mark.slow
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


def test_placements_stand_after_the_sampled_patches(bundled_body):
    sampled = sample_patches(bundled_body, 24, seed=3)
    free = int(np.setdiff1d(np.arange(1000), sampled.vertices)[0])
    both = with_placements(bundled_body, sampled, {"ring": free, "strap pod": int(sampled.vertices[5])})
    assert len(both) == 25
    np.testing.assert_array_equal(both.vertices[:24], sampled.vertices)
    assert both.vertices[24] == free
    assert both.names[24] == "ring"
    assert both.names[5] == "strap pod"
    others = np.delete(np.arange(24), 5)
    assert [both.names[patch] for patch in others] == [sampled.names[patch] for patch in others]
    assert find_patches(both.regions, both.names, "Strap Pod").tolist() == [5]


def test_a_placement_may_not_be_called_as_another_patch(bundled_body):
    sampled = sample_patches(bundled_body, 24, seed=3)
    free = int(np.setdiff1d(np.arange(1000), sampled.vertices)[0])
    with pytest.raises(ValueError, match="already: name your placement otherwise"):
        with_placements(bundled_body, sampled, {sampled.names[0].upper(): free})


def test_placements_are_read_from_tables_of_either_kind(tmp_path):
    (tmp_path / "a.csv").write_text("name;vertex\nstrap pod;1234\nRing;77\n", encoding="utf-8")
    assert read_placements(tmp_path / "a.csv") == {"strap pod": 1234, "Ring": 77}
    (tmp_path / "b.csv").write_text("name,vertex,x,y,z\npod,12,,,\nclip,,0.14,-0.06,0.98\n", encoding="utf-8")
    assert read_placements(tmp_path / "b.csv") == {"pod": 12, "clip": (0.14, -0.06, 0.98)}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("name,vertex\n", "names no placement"),
        ("name,vertex\npod,left\n", "line 2: 'pod' needs the number of a vertex, a spot, or x, y and z"),
        ("name,x,y,z\npod,1,2,\n", "line 2: 'pod' needs the number of a vertex, a spot, or x, y and z"),
        ("name,vertex\npod,1\npod,2\n", "line 3: 'pod' stands there a second time"),
        ("spot,vertex\npod,1\n", "needs the columns 'name'"),
    ],
)
def test_tables_that_are_not_placements_are_refused(tmp_path, text, sentence):
    (tmp_path / "own.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=sentence):
        read_placements(tmp_path / "own.csv")


def test_a_table_of_spots_by_a_tape_is_read(bundled_body, tmp_path):
    table = tmp_path / "places.csv"
    table.write_text("name,spot\npod,Left forearm  85% 50%\nclip,pelvis 40% 25%\n")
    placements = read_placements(table)
    assert placements == {"pod": "left forearm 85% 50%", "clip": "pelvis 40% 25%"}
    vertices = placement_vertices(bundled_body, placements)
    assert vertices["pod"] == vertex_at(bundled_body, Spot("left forearm", 85, 50))
    table.write_text("name,spot\npod,left forarm 85% 50%\n")
    with pytest.raises(ValueError, match=r"line 2: .*did you mean left forearm"):
        read_placements(table)
