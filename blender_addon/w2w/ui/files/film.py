# SPDX-License-Identifier: GPL-3.0-or-later
"""Film: the body with its map turns around, or moves as in a clip with its sensors' signals below."""

import subprocess
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

from ...core.files import folder_beside
from ...core.imu.recording import ImuRecording
from ...scene.base.actions import FIRST_FRAME, key_rate
from ...scene.base.playback import each_frame
from ...scene.movie import check_movies, movie
from ...scene.presentation import facing, posed, room_of, shown_surface
from ..jobs.jobs import Steps, as_steps, in_thread, on_body
from ..study import lists, signal_cache
from ..viewport.framing import dressed
from .exports import Export
from .pictures import LIGHT, MARGIN, SHAPE, choice, chosen_spots, load_drawing, words_on

RATE = 24
"""Frames per second of films."""

TURN = 5.0
"""Seconds that the body takes to turn around."""

ASIDE = np.pi / 6
"""How far from the front a moving body is seen, radians."""

SIZES = {"WIDE": (1920, 1080), "SQUARE": (1080, 1080)}
"""Width and height of films, pixels."""

FRAMED, DRAWN = 0.1, 0.8
"""About which share of the time it takes until the body's room is known, and until all frames are drawn."""


class Plan(NamedTuple):
    """What a film shows in each of its N frames."""

    pose: AbstractContextManager[None]
    items: Sequence[bpy.types.Object]
    frames: np.ndarray  # (N,), of the scene
    turns: np.ndarray  # (N,), of the camera from the body's front to the first sensor's side, radians
    recording: ImuRecording | None = None  # of the chosen sensors


def _plan(mesh: bpy.types.Object, what: str) -> Plan:
    """A turntable of the neutral body, or the clip that is chosen in the list."""
    study = mesh.w2w
    if what == "TURNTABLE":
        turns = np.linspace(0, 2 * np.pi, round(TURN * RATE), endpoint=False)
        return Plan(posed(mesh), [mesh], np.full(len(turns), bpy.context.scene.frame_current_final), turns)
    clip = study.clips[study.clip_index] if 0 <= study.clip_index < len(study.clips) else None
    if clip is None or clip.action is None:
        raise ValueError("Choose a clip in the list first (page Clips), or film a Turntable")
    seconds = (clip.action.frame_range[1] - FIRST_FRAME) / key_rate(clip.action)
    frames = FIRST_FRAME + key_rate(clip.action) * np.arange(0, max(seconds, 1 / RATE), 1 / RATE)
    recording = signal_cache.recording(clip) if clip.signals else None
    if recording is not None:
        chosen = [row.patch for row in lists.leading(study) if row.patch < recording.n_sensors]
        recording = replace(recording.at(chosen), clip=clip.name) if chosen else None
    turns = np.full(len(frames), ASIDE)
    return Plan(posed(mesh, clip.action), [*dressed(mesh)], frames, turns, recording)


@on_body
def film_steps(mesh: bpy.types.Object, path: Path, what: str, shape: str, light: str) -> Steps:
    """Draw frame by frame, each like a picture, and write them as a movie."""
    check_movies()
    yield from in_thread(load_drawing, "preparing", 0.0, 0.0)
    from ...drawing.body import Surface, ViewFrame, locate
    from ...drawing.heatmap import VIEW_PIXELS, moving_figure
    from ...drawing.page import shaped

    plan, page = _plan(mesh, what), partial(moving_figure, **words_on(mesh))
    count = len(plan.frames)
    frame_of = yield from in_thread(lambda _: page(recording=plan.recording), "drawing", 0.0, 0.0)

    def draw(number: int, surface: Surface, spots: tuple, view: ViewFrame, _: object) -> None:
        drawn = frame_of(surface.picture(view, light == "STUDIO"), locate([view], *spots), number / RATE)
        shaped(drawn, shape, "white").resize(SIZES[shape]).save(files[number], compress_level=1)

    with folder_beside(path) as folder, plan.pose:
        files = [Path(folder, f"{number:06d}.png") for number in range(count)]
        centres, width = yield from as_steps(room_of(mesh, plan.frames), "looking", 0.0, FRAMED)
        width *= MARGIN
        spots, front = chosen_spots(mesh), facing(mesh)
        side = _side(spots()[1], front)
        for number in each_frame(plan.frames):
            view = ViewFrame(front + side * plan.turns[number], centres[number], width, VIEW_PIXELS)
            work = partial(draw, number, Surface(*shown_surface(plan.items)), spots(), view)
            low, high = (FRAMED + (DRAWN - FRAMED) * (number + end) / count for end in (0, 1))
            yield from in_thread(work, f"frame {number + 1} of {count}", low, high)
        written = Path(folder, path.name)
        yield from as_steps(movie(files, written, SIZES[shape], RATE), "writing", DRAWN, 1.0)
        written.replace(path)
    if not bpy.app.background:
        subprocess.Popen([bpy.app.binary_path, "-a", "-f", str(RATE), "1", str(path)])  # Blender's own player
    return f"Saved the film: {path}"


def _side(normals: np.ndarray, front: float) -> float:
    """1 if the first of the sensors (N, 3) faces the left of a body, else -1."""
    return -1.0 if len(normals) and normals[0] @ (np.cos(front), np.sin(front), 0.0) < 0 else 1.0


class W2W_OT_export_film(Export, bpy.types.Operator):
    """Save the body with its map as a film: turning around, or moving with its sensors' signals below"""

    bl_label = "Film"

    usual = "film.mp4"
    what: choice(
        "Film",
        "What moves",
        TURNTABLE="The body turns around",
        CLIP="The chosen clip, with the sensors' signals",
    )
    shape: SHAPE
    light: LIGHT

    def write(self, body: bpy.types.Object, path: Path) -> Steps:
        return film_steps(body, path, self.what, self.shape, self.light)
