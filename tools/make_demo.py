# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the motions of `w2w demo` from the library that `w2w demo-library LIBRARY` wrote as FBX files.

python tools/make_demo.py LIBRARY
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import Body
from w2w.core.files import write_npz
from w2w.core.library.library import read_library
from w2w.core.motion.examples import DEMO, DEMO_STEP
from w2w.core.motion.motion import BODY_JOINTS, Motion
from w2w.core.motion.skinning import on_the_ground
from w2w.headless.runs.clip import load_clip


def main() -> None:
    """Retarget each clip to the bundled body and store the motions."""
    folder, body = Path(sys.argv[1]), Body.bundled()
    motions: dict[str, Motion] = {}
    clips = read_library(folder, folder / "labels.csv").clips
    for clip in sorted(clips, key=lambda clip: (clip.activity, clip.subject)):
        _, motion, _ = load_clip(clip, body)
        number = 1 + sum(known.activity == motion.activity for known in motions.values())
        motions[f"{motion.activity}_{number}.npz"] = motion
    write_npz(DEMO, stored(motions, body), compress=True)
    print(f"{len(motions)} motions, {DEMO.stat().st_size / 1e6:.1f} MB: {DEMO}")


def stored(motions: Mapping[str, Motion], body: Body) -> dict[str, np.ndarray]:
    """Motions of one frame rate, by the names of their files, as `demo_motions` reads them.

    Hands, which files do not keep, follow the forearms. `lifts` (N,), metres, stand each on the ground.
    """
    differences, lifts = [], []
    for motion in motions.values():
        turns = Rotation.from_matrix(motion.rotations.reshape(-1, 3, 3)).as_rotvec()
        values = np.hstack([motion.pelvis, turns.reshape(motion.n_frames, -1)])
        values[:, 3 + 3 * BODY_JOINTS :] = 0
        steps = np.round(values / DEMO_STEP).astype(np.int64)
        differences.append(np.diff(steps, n=2, axis=0, prepend=np.zeros((2, steps.shape[1]), np.int64)))
        turned = Rotation.from_rotvec((DEMO_STEP * steps[:, 3:]).reshape(-1, 3)).as_matrix()
        rounded = replace(
            motion, rotations=turned.reshape(motion.rotations.shape), pelvis=DEMO_STEP * steps[:, :3]
        )
        lifts.append(on_the_ground(body, rounded).pelvis[0, 2] - rounded.pelvis[0, 2])
    return {
        "files": np.array(list(motions)),
        "activities": np.array([motion.activity for motion in motions.values()]),
        "subjects": np.array([motion.subject for motion in motions.values()]),
        "frames": np.array([motion.n_frames for motion in motions.values()]),
        "lifts": np.array(lifts),
        "rate": np.array(next(iter(motions.values())).rate),
        "differences": np.asfortranarray(np.concatenate(differences).astype(np.int32)),
    }


if __name__ == "__main__":
    main()
