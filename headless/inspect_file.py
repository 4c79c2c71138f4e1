# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w inspect`: what a motion file holds, and whether and how it would be used."""

from __future__ import annotations

if __name__ == "__main__":  # blender --background --python headless/inspect_file.py -- FILE
    import sys
    from pathlib import Path

    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    from headless.from_blender import run_command

    run_command("inspect")

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from blender_addon.w2w.core.body import Body
from blender_addon.w2w.core.bone_maps import BoneMap
from blender_addon.w2w.core.library import Clip, activity_of
from blender_addon.w2w.core.motion import Motion
from blender_addon.w2w.core.skeleton import JOINT_INDEX
from blender_addon.w2w.core.skinning import joint_transforms
from blender_addon.w2w.core.source_motion import SourceMotion, UnusableMotion
from blender_addon.w2w.core.windows import WindowSpec

from .exit_codes import NOTHING_TO_DO, USAGE
from .load_alone import load_alone


def inspect(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A motion file: FBX, BVH or npz.")],
    bone_map: Annotated[list[Path] | None, typer.Option(help="Bone map of your own rig (JSON).")] = None,
) -> None:
    """Say what a motion file holds, and whether and how it would be used.

    Exit codes: 0 it would be used, 1 it would not (and why), 2 wrong use.
    """
    console = Console(highlight=False)
    clip = Clip(file, file.name, file.stem, activity_of(file.name))
    body = Body.bundled()
    try:
        bone_maps = [BoneMap.load(path) for path in bone_map or ()]
    except (ValueError, OSError) as error:
        console.print(str(error), style="red", markup=False)
        raise typer.Exit(USAGE) from error
    try:
        source, motion, details = load_alone(clip, body, bone_maps)
    except UnusableMotion as error:
        console.print(f"[red]{escape(file.name)} would be skipped:[/red] {escape(str(error).rstrip('.'))}.")
        raise typer.Exit(NOTHING_TO_DO) from error
    table = Table(show_header=False, box=None, title=escape(str(file)), title_justify="left")
    for row in (*_about_source(source, details), *_about_motion(motion, details, body)):
        table.add_row(*map(escape, row))
    console.print(table)
    used = f"[green]{escape(file.name)} would be used[/green]"
    console.print(f"{used} as '{escape(clip.activity)}' (from its file name).")


def _about_source(source: SourceMotion | Motion, details: dict) -> list[tuple[str, str]]:
    rows = []
    if isinstance(source, SourceMotion):
        rows.append(("take", f"'{source.take}', the one that moves"))
        rows.append(("skeleton", f"{len(source.bones) - 1} bones, named as {details['skeleton']} does"))
        if source.people > 1:
            rows.append(("people", f"{source.people}, of whom one is used"))
        height = np.ptp(source.rest[1:, :3, 3], axis=0).max()
        rows.append(
            ("size in the file", f"{height:.4g} units; {details['scale']:.4g} metres of the body in one")
        )
    rows.append(("frames", f"{details['frames']} at {details['frame_rate']:g} a second"))
    return rows


def _about_motion(motion: Motion, details: dict, body: Body) -> list[tuple[str, str]]:
    _, positions = joint_transforms(body, motion)
    across = motion.rotations[:, 0, :2, 0]
    turn = np.degrees(np.ptp(np.unwrap(np.arctan2(across[:, 1], across[:, 0]))[[0, -1]]))
    travel = np.linalg.norm(motion.pelvis[-1, :2] - motion.pelvis[0, :2])
    hands = [
        np.linalg.norm(np.diff(positions[:, JOINT_INDEX[f"{side}_wrist"]], axis=0), axis=1).sum()
        for side in ("left", "right")
    ]
    shortest = WindowSpec().shortest_s
    length = f"{details['duration_s']:.2f} s"
    if details["duration_s"] < shortest:
        length += f": too short for a window, which needs {shortest:g} s"
    return [
        ("duration", length),
        ("the body turns", f"{turn:.0f} degrees from first to last frame"),
        ("the body travels", f"{travel:.2f} m"),
        ("path of the hands", f"left {hands[0]:.2f} m, right {hands[1]:.2f} m"),
    ]
