# SPDX-License-Identifier: GPL-3.0-or-later
"""A card stands where it covers nothing, as large as it may; else where it covers least."""

import numpy as np

from w2w.drawing.places import GAP, FreeArea, place_all

FREE = FreeArea(100.0, 900.0, 0.0, 600.0)
BODY = np.column_stack([np.full(50, 500.0), np.linspace(10, 590, 50)])
"""A body that stands upright in the middle."""


def card(scale):
    return 300 * scale, 200 * scale


def folded(scale):
    return 100 * scale, 50 * scale


def edges(width, gap):
    return [FREE.left + gap, FREE.right - width - gap]


def test_a_card_stands_whole_at_the_first_edge_that_is_free():
    (stand,) = place_all([[card]], FREE, BODY, [], 1.0, edges)
    assert (stand.x, stand.y, stand.scale, stand.covers) == (FREE.left + GAP, GAP, 1.0, 0.0)


def test_a_second_card_stands_over_no_other():
    stands = place_all([[card]] * 2, FREE, BODY, [], 1.0, edges)
    first, second = (stand.box([card]) for stand in stands)
    assert second.bottom >= first.top or second.left >= first.right
    assert not any(second.holds(*point) for point in BODY)


def test_a_card_shrinks_before_it_folds_and_folds_before_it_covers_the_body():
    beside = FREE._replace(left=250.0, right=750.0)
    lefts = lambda width, gap: [beside.left + gap, beside.right - width - gap]  # noqa: E731
    (stand,) = place_all([[card, folded]], beside, BODY, [], 1.0, lefts)
    assert (stand.form, stand.covers) == (0, 0.0)
    assert stand.scale < 1
    narrow = FREE._replace(left=380.0, right=620.0)
    lefts = lambda width, gap: [narrow.left + gap, narrow.right - width - gap]  # noqa: E731
    (stand,) = place_all([[card, folded]], narrow, BODY, [], 1.0, lefts)
    assert (stand.form, stand.covers) == (1, 0.0)


def test_where_nothing_is_free_it_covers_least():
    crowd = np.random.default_rng(0).uniform((100, 0), (900, 600), (400, 2))
    crowd = crowd[(crowd[:, 0] < 500) | (np.arange(len(crowd)) % 5 == 0)]
    (stand,) = place_all([[card]], FREE, crowd, [], 1.0, edges)
    assert stand.covers > 0
    assert stand.x > 500
