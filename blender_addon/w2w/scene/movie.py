# SPDX-License-Identifier: GPL-3.0-or-later
"""A movie file of pictures, as Blender's own FFmpeg writes it, in the background where there is a window."""

from collections.abc import Generator, Sequence
from pathlib import Path

from ..core.wording import restated
from .base.module import bpy
from .base.playback import kept

NO_FFMPEG = "This build of Blender has no FFmpeg, which writes films: take one from blender.org"
UNFINISHED = (
    "The film was stopped while it was written, or this Blender has no H.264 (see the system console)"
)


def check_movies() -> None:
    """Refuse a Blender that writes no movies."""
    if not bpy.app.build_options.codec_ffmpeg:
        raise ValueError(NO_FFMPEG)


def movie(
    pictures: Sequence[Path], path: Path, size: tuple[int, int], rate: int
) -> Generator[float, None, None]:
    """Write pictures, all of one size and in one folder, as an mp4 file; yields the share that is done.

    Raises ValueError if Blender could not, or was stopped by Esc.
    """
    done: list[bool] = []

    def note(*_: object) -> None:
        done.append(True)

    scene = bpy.data.scenes.new("W2W Film")
    try:
        _set_up(scene, pictures, path, size, rate)
        bpy.app.handlers.render_complete.append(note)
        with kept((bpy.context.preferences.view, "render_display_type")), restated(UNFINISHED, RuntimeError):
            bpy.context.preferences.view.render_display_type = "NONE"
            how = "EXEC_DEFAULT" if bpy.app.background else "INVOKE_DEFAULT"
            bpy.ops.render.render(how, animation=True, scene=scene.name)
        while bpy.app.is_job_running("RENDER"):
            yield (scene.frame_current - 1) / len(pictures)
        if not done or not path.is_file():
            raise ValueError(UNFINISHED)
    finally:
        if note in bpy.app.handlers.render_complete:
            bpy.app.handlers.render_complete.remove(note)
        bpy.data.scenes.remove(scene)


def _set_up(
    scene: bpy.types.Scene, pictures: Sequence[Path], path: Path, size: tuple[int, int], rate: int
) -> None:
    """Let a scene show the pictures, one a frame, and be written as they are."""
    editor, render = scene.sequence_editor_create(), scene.render
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences  # until 4.3
    strip = strips.new_image("Film", str(pictures[0]), 1, 1)
    for picture in pictures[1:]:
        strip.elements.append(picture.name)
    scene.frame_start, scene.frame_end = 1, len(pictures)
    render.resolution_x, render.resolution_y, render.fps, render.dither_intensity = *size, rate, 0.0
    scene.view_settings.view_transform = "Standard"
    if hasattr(render.image_settings, "media_type"):  # from 5.0 on
        render.image_settings.media_type = "VIDEO"
    render.image_settings.file_format = "FFMPEG"
    render.ffmpeg.format, render.ffmpeg.codec, render.ffmpeg.constant_rate_factor = "MPEG4", "H264", "HIGH"
    render.filepath, render.use_file_extension = str(path), False
