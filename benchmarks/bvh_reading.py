# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W's reader of BVH beside Blender's importer: processor time, and how far the two motions are apart.

    python -m benchmarks.bvh_reading [--folder ../shared/data/bvh] [--every 1]

Both roads read the same files in turn, to a motion on the body. Blender keeps Euler angles in single
precision, which near their pole tells a turn no closer than a hundredth of a radian; the reader does not.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np

from w2w.core.body.body import Body
from w2w.core.motion.motion import Motion
from w2w.core.motion.source import SourceMotion, UnusableMotion
from w2w.core.readers.bvh import read_bvh
from w2w.core.reading.guard import quiet_output
from w2w.core.retargeting.repair import repaired
from w2w.core.retargeting.retarget import retarget
from w2w.scene.motion.takes import read_clip

DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "bvh"


def through_blender(path: Path) -> SourceMotion:
    """Read a file as W2W did before it had a reader."""
    with quiet_output():
        return repaired(read_clip(path))


def timed(read: Callable[[Path], SourceMotion], path: Path) -> tuple[SourceMotion, float]:
    """What a reader finds, and the milliseconds of processor time it takes."""
    start = time.process_time()
    found = read(path)
    return found, 1000 * (time.process_time() - start)


def apart(one: Motion, other: Motion) -> np.ndarray:
    """Degrees between the turns of two motions, joint by joint and frame by frame."""
    chord = np.linalg.norm(one.rotations - other.rotations, axis=(2, 3)) / np.sqrt(8)
    return np.degrees(2 * np.arcsin(np.minimum(chord, 1))).ravel()


def compare(paths: list[Path]) -> None:
    """Read all files on both roads and print what came of it."""
    body = Body.bundled()
    ours, theirs, away, pelvis = [], [], [], []
    for path in paths:
        try:
            made, spent = timed(read_bvh, path)
            imported, theirs_spent = timed(through_blender, path)
        except UnusableMotion:
            continue
        ours.append(spent)
        theirs.append(theirs_spent)
        a, b = (retarget(source, body).motion for source in (made, imported))
        away.append(apart(a, b))
        pelvis.append(np.abs(a.pelvis - b.pelvis).max())
    turns = np.concatenate(away)
    print(f"{len(ours)} of {len(paths)} files can be used")
    for name, spent in (("W2W's reader", ours), ("Blender's importer", theirs)):
        mean, median = statistics.mean(spent), statistics.median(spent)
        print(f"{name:18s} {mean:7.1f} ms a file, median {median:.1f}")
    print(f"ratio {sum(ours) / sum(theirs):.3f}")
    print("\njoints of the body apart: median, 99.9 %, most")
    print(f"turns  {np.median(turns):.5f}, {np.percentile(turns, 99.9):.5f}, {turns.max():.4f} degrees")
    print(f"pelvis, most of a file: {np.median(pelvis):.1e} m, of all files {max(pelvis):.1e} m")


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--folder", type=Path, default=DATA)
    parser.add_argument("--every", type=int, default=1)
    choice = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    compare(sorted(choice.folder.rglob("*.bvh"))[:: choice.every])


if __name__ == "__main__":
    main()
