"""Cloth that is stretched as no fabric is has caught on something."""

import numpy as np

from w2w.core.imu.cover import ClothSensors, RestLengths, caught_sentence, caught_sentences

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
EDGES = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [0, 0]])


def facts(**caught):
    """What a clip of 90 frames tells of cloth without sensors."""
    return ClothSensors(np.arange(0), np.empty((90, 0, 4, 4)), 30.0, caught).facts()


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


def test_clips_in_which_cloth_caught_are_named_and_counted():
    fine = facts(tshirt=0)
    assert fine == {}
    bad = facts(tshirt=7, trousers=0)
    assert bad == {"cloth_caught": {"tshirt": 7}, "cloth_frames": 90}
    (sentence,) = caught_sentences([("walk", fine), ("kick", bad)])
    assert sentence == (
        "In kick cloth caught on the body, stretched to more than 2 times its length: tshirt in 7 of 90 "
        "frames: do not trust what its sensors feel there"
    )
    assert caught_sentences([("walk", fine)]) == []


def test_many_clips_are_not_all_named():
    bad = facts(tshirt=7)
    sentences = caught_sentences([(f"kick{number}", bad) for number in range(5)])
    assert len(sentences) == 4
    assert sentences[-1] == "Cloth caught in 2 more clips: see cloth_caught in clips.jsonl"
