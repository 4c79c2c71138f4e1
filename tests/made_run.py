# SPDX-License-Identifier: GPL-3.0-or-later
"""A run over real BVH clips and a broken one, as it is left overnight."""

from __future__ import annotations

import shutil
from functools import partial
from pathlib import Path

from w2w.headless.reports.draw import draw_alone, write_blend

from .command_line import cli
from .here import clips_here

ACTIVITIES = ("bow", "run", "walk-left")
N_PATCHES = 48


def make_run(data: Path, folder: Path, patches: int = N_PATCHES, *more: str) -> Path:
    """Run `w2w run` into a folder and save its study.blend; the pictures beside it are left out.

    Returns
    -------
    Path
        The results folder.
    """
    for activity in ACTIVITIES:
        (folder / "clips" / activity).mkdir(parents=True)
        for file in sorted((data / "bvh/bandai_namco").glob(f"dataset-1_{activity}_*.bvh")):
            shutil.copy(file, folder / "clips" / activity)
    (folder / "clips" / "bow" / "broken.bvh").write_text("HIERARCHY")
    out = folder / "results"
    options = f"--patches {patches} --stride 0.5 --forbid foot --max 3 --target 0.85 --workers 1"
    with clips_here():
        code, said = cli("run", folder / "clips", "--out", out, "--no-pictures", *options.split(), *more)
        if code:
            raise RuntimeError(said)
        why = draw_alone(partial(write_blend, out, to=out))
    if why:
        raise RuntimeError(why)
    return out
