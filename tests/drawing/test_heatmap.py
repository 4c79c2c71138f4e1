# SPDX-License-Identifier: GPL-3.0-or-later
"""Finished pictures: right colours and places, nothing cut, the same bytes every time."""

import matplotlib.image
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from w2w.core.colours import Scale, colour_table
from w2w.drawing.heatmap import SPARE, VIEW_PIXELS, VIEW_SIZE, heatmap_figure, subset_figure
from w2w.drawing.page import BADGE, DPI, MARGIN, SensorList, apart

from ..rings import by_day

pytestmark = pytest.mark.later

SIZE = 300
SCALE = Scale(0.2, 0.9)
TOP, BOTTOM, LEFT, RIGHT = 20, 280, 60, 240
LONG = "a very long title about carrying boxes of all sizes up and down the stairs of many a house " * 2


@pytest.fixture
def views():
    """Two grey rectangles on a transparent ground, as a body would be."""
    view = np.zeros((SIZE, SIZE, 4), dtype=np.uint8)
    view[TOP:BOTTOM, LEFT:RIGHT] = (128, 128, 128, 255)
    return [view, view]


def read(path):
    return matplotlib.image.imread(path)[..., :3]


def on_page(image, view, column, row):
    """Where a pixel of a view is in the finished picture: column and row."""
    width = VIEW_SIZE * (RIGHT - LEFT) / (BOTTOM - TOP)
    x = MARGIN + view * (width + MARGIN) + width * (column - LEFT) / (RIGHT - LEFT)
    y = MARGIN + VIEW_SIZE * (BOTTOM - row) / (BOTTOM - TOP)
    return x * DPI, image.shape[0] - y * DPI


def assert_white_edge(image, inches=0.2):
    edge = round(inches * DPI)
    for strip in (image[:edge], image[-edge:], image[:, :edge], image[:, -edge:]):
        assert (strip == 1).all()


def test_the_colour_bar_has_the_map_s_colours_in_order(views, tmp_path):
    heatmap_figure(tmp_path / "map.png", views, "Walking", SCALE)
    image = read(tmp_path / "map.png")
    table = colour_table()
    assert_white_edge(image)
    # the one column of the page whose colours are nearest to the map's, from the high to the low end
    is_high = np.abs(image - table[-1]).max(axis=-1) < 0.02
    is_low = np.abs(image - table[0]).max(axis=-1) < 0.02
    column = int(np.median(np.argwhere(is_high)[:, 1]))
    top, bottom = np.flatnonzero(is_high[:, column])[0], np.flatnonzero(is_low[:, column])[-1]
    assert bottom - top == pytest.approx(0.6 * VIEW_SIZE * DPI, abs=4)
    shown = image[np.linspace(top + 2, bottom - 2, 50).round().astype(int), column]
    expected = table[np.linspace(len(table) - 1, 0, 50).round().astype(int)]
    np.testing.assert_allclose(shown, expected, atol=0.03)


def test_the_views_stand_where_they_should(views, tmp_path):
    views[1] = views[1].copy()
    views[1][TOP:BOTTOM, LEFT:RIGHT, :3] = (200, 40, 40)
    heatmap_figure(tmp_path / "map.png", views, "Walking", SCALE)
    image = read(tmp_path / "map.png")
    for view, colour in ((0, (128, 128, 128)), (1, (200, 40, 40))):
        column, row = on_page(image, view, (LEFT + RIGHT) / 2, (TOP + BOTTOM) / 2)
        np.testing.assert_allclose(image[round(row), round(column)], np.array(colour) / 255, atol=0.01)


@pytest.mark.parametrize("short", [0, 1, SPARE])
def test_a_body_of_the_page_s_own_pixels_is_not_scaled(tmp_path, short):
    """Nor one a little lower: stripes a pixel wide stay what they are."""
    view = np.zeros((VIEW_PIXELS + 40, VIEW_PIXELS + 40, 4), dtype=np.uint8)
    body = view[20 : 20 + VIEW_PIXELS - short, 100:700]
    body[..., 3] = 255
    body[:, 1::2, :3] = 200
    heatmap_figure(tmp_path / "map.png", [view, view], "Walking", SCALE)
    left, bottom = round(MARGIN * DPI), round(MARGIN * DPI)
    row = read(tmp_path / "map.png")[-bottom - VIEW_PIXELS // 2, left : left + body.shape[1], 0]
    np.testing.assert_array_equal(np.rint(row * 255), body[0, :, 0])


@pytest.mark.parametrize(("view", "column", "row"), [(0, 100, 60), (1, 200, 250), (1, 150, 150)])
def test_a_marker_is_on_its_place(views, tmp_path, view, column, row):
    arguments = (views, "Chosen", SCALE, [(view, column, row)])
    subset_figure(tmp_path / "subset.png", *arguments, SensorList(["left wrist"], [0.8], [""]))
    image = read(tmp_path / "subset.png")
    x, y = on_page(image, view, column, row)
    ring = np.linspace(0, 2 * np.pi, 60)
    inner, outer = (
        image[
            (y + radius * np.sin(ring)).round().astype(int), (x + radius * np.cos(ring)).round().astype(int)
        ]
        for radius in (0.85 * BADGE * DPI, 1.3 * BADGE * DPI)
    )
    assert np.median(inner) > 0.95
    np.testing.assert_allclose(np.median(outer, axis=0), 128 / 255, atol=0.02)


@pytest.mark.parametrize("count", by_day([12], [1, 12]))
def test_nothing_is_cut_however_long_the_names(views, tmp_path, count):
    places = [(number % 2, 100 + 8 * number, 60) for number in range(count)]
    names = [f"{number} left lower leg lateral, quite near to the ankle" for number in range(count)]
    scores = np.linspace(0.5, 1, count)
    sensors = SensorList(names, scores, names, 0.9)
    subset_figure(tmp_path / "a.png", views, LONG, SCALE, places, sensors, LONG * 2)
    heatmap_figure(tmp_path / "b.png", views, LONG, Scale(0.98765, 0.98769, "Mean F1"), LONG * 2)
    assert_white_edge(read(tmp_path / "a.png"))
    assert_white_edge(read(tmp_path / "b.png"))


def test_mathematics_in_names_is_just_text(views, tmp_path):
    heatmap_figure(tmp_path / "map.png", views, "$\\frac{lift$_{2", Scale(0.5, 0.5), "100 % of $5")
    assert (tmp_path / "map.png").stat().st_size > 0


def test_the_same_content_gives_the_same_bytes(views, tmp_path):
    for name in ("one.png", "two.png"):
        one = SensorList(["left wrist"], [0.8], ["a card"], 0.9)
        subset_figure(tmp_path / name, views, "Chosen", SCALE, [(0, 100, 60)], one)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()


@pytest.mark.parametrize(("count", "shown"), [(3, True), (4, False)])
def test_cards_are_drawn_where_there_is_room_for_all(views, tmp_path, count, shown):
    names, scores, markers = ["patch"] * count, [0.5] * count, [(0, 100.0, 100.0)] * count
    plain = SensorList(names, scores, [""] * count)
    subset_figure(tmp_path / "plain.png", views, "Title", SCALE, markers, plain)
    cards = ["Left forearm, 85 % of the way from elbow crease to wrist crease. " * 2] * count
    sensors = plain._replace(cards=cards)
    subset_figure(tmp_path / "cards.png", views, "Title", SCALE, markers, sensors)
    assert ((tmp_path / "plain.png").read_bytes() != (tmp_path / "cards.png").read_bytes()) is shown


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**16), count=st.integers(0, 12), spread=st.floats(0, 60))
def test_badges_never_overlap_and_stay_near(seed, count, spread):
    anchors = np.random.default_rng(seed).uniform(-spread, spread, (count, 2))
    badges = apart(anchors, 20.0)
    gaps = np.linalg.norm(badges[:, None] - badges[None], axis=-1)[np.triu_indices(count, 1)]
    assert (gaps > 17).all()
    assert (np.linalg.norm(badges - anchors, axis=1) < 20.0 * max(count, 1)).all()
