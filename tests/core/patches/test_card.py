# SPDX-License-Identifier: GPL-3.0-or-later
"""The card's arrow and slip: truth on patches whose frame and scores are made up."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.patches.card import FARTHEST_CM, Card, arrow_in_words, slip_cm
from w2w.core.patches.spots import Spot, vertex_at
from w2w.core.patches.strip_graph import StripGraph


def arrow(body, patches, text, direction):
    """Words for an arrow from a spot to the vertex about 3 cm on in a direction."""
    vertex = vertex_at(body, Spot.parse(text))
    spoke = body.vertices - body.vertices[vertex]
    near = np.linalg.norm(spoke, axis=1)
    straight = np.where(
        (near > 0.015) & (near < 0.05), spoke @ np.array(direction) / np.maximum(near, 1e-9), -1
    )
    triangles = np.array([[vertex, int(straight.argmax()), 0]])
    one = replace(patches, vertices=np.array([vertex]), triangles=triangles)
    return arrow_in_words(body, one, 0)


@pytest.mark.parametrize(
    ("text", "direction", "words"),
    [
        ("left forearm 50% 50%", (1, 0, 0), "along the forearm, towards the hand"),
        ("right forearm 50% 50%", (1, 0, 0), "along the forearm, towards the elbow"),
        ("right thigh 50% 0%", (0, 0, -1), "along the thigh, towards the knee"),
        ("right thigh 50% 0%", (-1, 0, 0), "around the thigh, towards the outer side"),
        ("chest 50% 50%", (1, 0, 0), "around the trunk, towards the left side"),
        ("left foot 60% 0%", (0, -1, 0), "along the foot, towards the toes"),
    ],
)
def test_the_arrow_points_where_the_words_say(bundled_body, patches, text, direction, words):
    assert arrow(bundled_body, patches, text, direction).startswith(words)


def test_an_arrow_between_two_ways_says_how_far_it_is_turned(bundled_body, patches):
    words = arrow(bundled_body, patches, "left thigh 50% 0%", (0.5, 0, -0.87))
    assert words.startswith("along the thigh, towards the knee, turned ")
    assert words.endswith("° to the outer side")


def test_every_patch_has_an_arrow_that_runs_along_or_around(bundled_body, patches):
    said = [arrow_in_words(bundled_body, patches, patch) for patch in range(len(patches))]
    assert all(words.startswith(("along the ", "around the ")) for words in said)


def test_slip_ends_before_the_first_patch_that_falls(bundled_body, patches):
    graph = StripGraph.of(bundled_body.vertices, bundled_body.faces)
    away = 100 * graph.distances(int(patches.vertices[40]))[patches.vertices]
    order = np.argsort(away)
    even = np.full(len(patches), 0.8)
    assert slip_cm(bundled_body, patches, even, 40) == FARTHEST_CM
    assert slip_cm(bundled_body, patches, np.where(away > 0, 0.77, 0.8), 40) == 0
    third = even.copy()
    third[order[3]] = 0.77
    assert slip_cm(bundled_body, patches, third, 40) == pytest.approx(away[order[2]])
    third[order[3]] = 0.78
    assert slip_cm(bundled_body, patches, third, 40) == FARTHEST_CM


def test_slip_is_not_asked_where_nothing_is_known(bundled_body, patches):
    with pytest.raises(ValueError, match="has no expected F1"):
        slip_cm(bundled_body, patches, np.full(len(patches), np.nan), 3)


@pytest.mark.parametrize(
    ("slip", "turn", "words"),
    [
        (5, 20, "May slip 5 cm or turn 20° before F1 falls by .02."),
        (5, None, "May slip 5 cm before F1 falls by .02."),
        (5, 0, "May slip 5 cm before F1 falls by .02. Must not turn."),
        (0, 30, "May turn 30° before F1 falls by .02. Must not slip."),
        (0, 0, "Must not slip or turn."),
        (FARTHEST_CM, 90, "May slip 10 cm or more or turn 90° or more before F1 falls by .02."),
    ],
)
def test_a_card_says_what_a_sensor_may_do(slip, turn, words):
    card = Card(0, "chest 35% 50%", "chest, back of the trunk", "along the trunk", slip, turn)
    assert card.in_words() == f"Chest, back of the trunk. Arrow along the trunk. {words}"
