# SPDX-License-Identifier: GPL-3.0-or-later
"""A run over real BVH clips and a broken one, as it is left overnight."""

from __future__ import annotations

import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

from w2w.headless.reports.draw import draw_side_by_side, write_blend

ACTIVITIES = ("bow", "run", "walk-left")
N_PATCHES = 48


def make_run(data: Path, folder: Path, patches: int = N_PATCHES) -> Path:
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
    options = f"--patches {patches} --stride 0.5 --forbid foot --max 3 --target 0.85 --workers 1"
    done = subprocess.run(
        [sys.executable, "-m", "headless", "run", folder / "clips", "--out", folder / "results"]
        + [*options.split(), "--no-pictures"],
        cwd=Path(__file__).resolve().parents[1],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(done.stdout + done.stderr)
    out = folder / "results"
    why = draw_side_by_side([partial(write_blend, to=out)], out)[0]
    if why:
        raise RuntimeError(why)
    return out
