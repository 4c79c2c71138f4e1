# SPDX-License-Identifier: GPL-3.0-or-later
"""A film has its frames, its shape and its signals; what ends early leaves nothing."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from PIL import Image

from w2w.scene import movie
from w2w.scene.base.body import armature_of
from w2w.scene.base.playback import active_action
from w2w.ui.files import film
from w2w.ui.files.film import film_steps

from .made_study import make_study

SIZE = (320, 180)


@pytest.fixture
def body(blender: None, library: Path, monkeypatch: pytest.MonkeyPatch) -> bpy.types.Object:  # noqa: ARG001
    """A ranked body whose films are short and small."""
    monkeypatch.setattr(film, "TURN", 3 / film.RATE)
    monkeypatch.setattr(film, "SIZES", {"WIDE": SIZE, "SQUARE": (180, 180)})
    return make_study(library)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """The frames of the film that is made meanwhile."""
    frames: list[np.ndarray] = []

    def seen(files, *rest):
        frames.extend(np.array(Image.open(file)) for file in files)
        return movie.movie(files, *rest)

    monkeypatch.setattr(film, "movie", seen)
    return frames


def made(steps) -> str:
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value


def coloured(frame: np.ndarray) -> np.ndarray:
    return np.ptp(frame.astype(int), axis=-1) > 40


def test_a_turntable_is_a_movie_of_a_body_that_turns(body, drawn, tmp_path):
    scenes = [*bpy.data.scenes]
    path = tmp_path / "film.mp4"
    assert str(path) in made(film_steps(body, path, "TURNTABLE", "WIDE", "STUDIO"))
    assert [*tmp_path.iterdir()] == [path]
    shown = bpy.data.images.load(str(path))
    assert shown.source == "MOVIE"
    assert (*shown.size,) == SIZE
    assert shown.frame_duration == 3
    assert [*bpy.data.scenes] == scenes
    assert all(coloured(frame).sum() > 500 for frame in drawn)
    assert (np.abs(drawn[0].astype(int) - drawn[1]).max(axis=-1) > 40).sum() > 200


def test_a_clip_moves_above_its_signals_and_comes_back(body, drawn, tmp_path, monkeypatch):
    clips = body.w2w.clips
    body.w2w.clip_index = next(index for index, clip in enumerate(clips) if clip.activity == "waving")
    monkeypatch.setattr(film, "RATE", 2)
    before = bpy.context.scene.frame_current, active_action(armature_of(body))
    made(film_steps(body, tmp_path / "film.mp4", "CLIP", "SQUARE", "FLAT"))
    assert (bpy.context.scene.frame_current, active_action(armature_of(body))) == before
    changed = np.abs(drawn[0].astype(int) - drawn[2]).max(axis=-1) > 40
    assert changed[40:115].any()  # the body
    assert changed[136:149].any()  # the line in its signals
    assert all(bone.matrix_basis.is_identity for bone in armature_of(body).pose.bones)


def test_without_a_sensor_a_clip_is_filmed_without_signals(body, drawn, tmp_path, monkeypatch):
    monkeypatch.setattr(film, "RATE", 1)
    body.w2w.worn.clear()
    body.w2w.chosen.clear()
    made(film_steps(body, tmp_path / "film.mp4", "CLIP", "WIDE", "STUDIO"))
    assert all(coloured(frame).sum() > 500 for frame in drawn)


def test_a_film_that_is_stopped_leaves_nothing(body, tmp_path):
    steps = film_steps(body, tmp_path / "film.mp4", "TURNTABLE", "WIDE", "STUDIO")
    while "frame 2" not in next(steps).text:
        pass
    assert any(tmp_path.iterdir())
    steps.close()
    assert not any(tmp_path.iterdir())
    assert (
        body.find_armature().animation_data is None
        or not body.find_armature().pose.bones["left_shoulder"].rotation_quaternion.angle
    )


def test_a_blender_without_ffmpeg_says_where_one_is(body, tmp_path, monkeypatch):
    class Build:
        codec_ffmpeg = False

    monkeypatch.setattr(movie, "bpy", type("Lacking", (), {"app": type("App", (), {"build_options": Build})}))
    with pytest.raises(ValueError, match=r"no FFmpeg.*blender\.org"):
        made(film_steps(body, tmp_path / "film.mp4", "TURNTABLE", "WIDE", "STUDIO"))


def test_no_clip_that_is_chosen_is_said(body, tmp_path):
    body.w2w.clip_index = -1
    with pytest.raises(ValueError, match="Choose a clip"):
        made(film_steps(body, tmp_path / "film.mp4", "CLIP", "WIDE", "STUDIO"))
