# SPDX-License-Identifier: GPL-3.0-or-later
"""A movie has the pictures it is given, in their size, and Blender is as it was before."""

import re

import bpy
import pytest
from PIL import Image

from w2w.scene.movie import UNFINISHED, movie

pytestmark = pytest.mark.usefixtures("empty_file")

SIZE = (64, 48)


@pytest.fixture
def pictures(tmp_path):
    """Four pictures, ever lighter."""
    paths = [tmp_path / f"{number}.png" for number in range(4)]
    for number, path in enumerate(paths):
        Image.new("RGB", SIZE, (60 * number,) * 3).save(path)
    return paths


def test_a_movie_has_the_pictures_and_leaves_blender_as_it_was(pictures, tmp_path):
    before = [*bpy.data.scenes], bpy.context.preferences.view.render_display_type
    path = tmp_path / "film.mp4"
    assert [*movie(pictures, path, SIZE, 12)] == []  # without a window it is written at once
    assert ([*bpy.data.scenes], bpy.context.preferences.view.render_display_type) == before
    clip = bpy.data.movieclips.load(str(path))
    assert (*clip.size, clip.frame_duration, clip.fps) == (*SIZE, 4, 12)


def test_a_movie_that_is_not_written_is_said(pictures, tmp_path):
    (tmp_path / "film.mp4").mkdir()
    scenes = [*bpy.data.scenes]
    with pytest.raises(ValueError, match=re.escape(UNFINISHED)):
        [*movie(pictures, tmp_path / "film.mp4", SIZE, 12)]
    assert [*bpy.data.scenes] == scenes
