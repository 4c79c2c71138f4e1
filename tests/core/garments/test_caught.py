"""Cloth that is stretched as no fabric is has caught on something."""

import numpy as np

from w2w.core.garments.caught import RestLengths, caught_sentence

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
EDGES = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [0, 0]])


def test_an_edge_more_than_twice_its_length_has_caught():
    lengths = RestLengths(SQUARE, EDGES)
    assert not lengths.caught(SQUARE)
    assert not lengths.caught(1.99 * SQUARE)
    pulled = SQUARE.copy()
    pulled[2] = 3, 1, 0
    assert lengths.caught(pulled)


def test_crumpled_cloth_and_vertices_that_are_not_there_have_not():
    lengths = RestLengths(SQUARE, EDGES)
    assert not lengths.caught(0.1 * SQUARE)
    gone = SQUARE.copy()
    gone[2] = np.nan
    assert not lengths.caught(gone)


def test_it_is_said_of_the_garments_that_it_happened_to():
    assert caught_sentence({"T-Shirt": 0, "Trousers": 0}, 90) == ""
    assert caught_sentence({"T-Shirt": 0, "Trousers": 7}, 90) == (
        "cloth caught on the body, stretched to more than 2 times its length: Trousers in 7 of 90 frames"
    )
