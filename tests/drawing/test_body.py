# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a coloured body: every colour at its place, in every view."""

import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.drawing.body import GLEAM, SHADE_DEPTH, BodyPictures, Surface, ViewFrame, locate, size_for


@pytest.fixture(scope="module")
def body():
    return Body.bundled()


def test_pictures_have_the_colours_asked_for(body):
    """Left half orange, right half blue: each is on its own side, and swapped from behind."""
    orange, blue = np.array([0.9, 0.5, 0.1]), np.array([0.1, 0.3, 0.8])
    colours = np.where(body.vertices[:, :1] > 0, orange, blue)
    front, back = BodyPictures(body, size=240).coloured(colours)
    for picture, left_is_orange in ((front, False), (back, True)):
        assert picture.shape == (240, 240, 4)
        assert picture.dtype == np.uint8
        assert picture[0, 0, 3] == 0
        left, right = picture[:, :112], picture[:, 128:]
        for half, is_orange in ((left, left_is_orange), (right, not left_is_orange)):
            shown = half[half[..., 3] == 255][:, :3] / 255
            target = orange if is_orange else blue
            np.testing.assert_allclose(np.median(shown, axis=0), target, atol=0.12)
            assert (shown <= target + GLEAM * (1 - target) + 0.01).all()
            assert (shown >= target * (1 - SHADE_DEPTH) - 0.01).all()


def test_each_pixel_takes_its_colour_where_it_lies_on_the_body(body):
    pictures = BodyPictures(body, size=240)
    for frame, shade in zip(pictures.frames, pictures._shades, strict=True):
        weights = shade.share / shade.share.sum(axis=1)[:, None]
        places = weights @ body.vertices
        rows, columns = np.divmod(shade.shown, 240)
        off = np.abs(frame.to_pixels(places) - np.stack([columns, rows], axis=1) - 0.5).max(axis=1)
        assert (off < 1e-3).mean() > 0.85  # the others are of the soft outline
        assert off.max() < 2
        facing = body.vertex_normals[shade.share.indices.reshape(-1, 3)].mean(axis=1) @ frame.towards_camera
        assert (facing > -0.2).all()


def test_what_lies_nearer_hides_what_lies_behind(body):
    """From the left, the left hand hides the chest and the other arm."""
    colours = np.where(body.vertices[:, :1] > 0.5, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    pictures = BodyPictures(body, size=240, views=("left", "right"))
    hand = body.vertices[body.vertices[:, 0].argmax()]
    column, row = pictures.frames[0].to_pixels(hand).astype(int)
    left, right = pictures.coloured(colours)
    assert left[row, column, 0] > left[row, column, 2]
    assert right[row, 239 - column, 2] > right[row, 239 - column, 0]


def test_a_body_is_so_many_pixels_high(body):
    for picture in BodyPictures(body, size_for(body, 157)).coloured(np.full_like(body.vertices, 0.5)):
        assert np.ptp(np.flatnonzero((picture[..., 3] > 0).any(axis=1))) + 1 in range(157, 161)


def test_a_place_is_located_in_the_view_that_it_faces(body):
    colours = np.zeros_like(body.vertices)
    chest = np.abs(body.vertices - (0.0, -0.1, 1.3)).sum(axis=1).argmin()
    colours[chest] = (1.0, 0.0, 0.0)
    pictures = BodyPictures(body, size=480)
    ((view, column, row),) = pictures.locate(body.vertices[[chest]], np.array([[0.0, -1.0, 0.0]]))
    red = (
        pictures.coloured(colours)[view][..., 0].astype(float) - pictures.coloured(0 * colours)[view][..., 0]
    )
    assert view == 0
    np.testing.assert_allclose(np.unravel_index(red.argmax(), red.shape), (row, column), atol=1.5)


def test_a_place_that_no_view_sees_has_none_and_the_others_keep_their_numbers(body):
    front = ViewFrame.of(body, "front", 100)
    places = locate([front], np.zeros((3, 3)), np.array([[0, -1.0, 0], [0, 1.0, 0], [0.5, -1.0, 0]]))
    assert [view for view, _, _ in places] == [0, -1, 0]


def test_without_light_a_surface_has_its_own_colours(body):
    colours = np.full_like(body.vertices, 0.5)
    surface, frame = Surface(body.vertices, body.faces, colours), ViewFrame.of(body, "front", 240)
    flat, lit = surface.picture(frame, lit=False), surface.picture(frame)
    assert set(np.unique(flat[flat[..., 3] == 255][:, :3])) <= {127, 128}
    assert np.ptp(lit[lit[..., 3] == 255][:, 0]) > 40
    np.testing.assert_array_equal(lit, BodyPictures(body, 240).coloured(colours)[0])
