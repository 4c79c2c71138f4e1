# SPDX-License-Identifier: GPL-3.0-or-later
"""What our garments do on a body that stands still, after the usual run-up, and what a frame takes.

    python -m benchmarks.cloth_at_rest [tshirt|trousers] [before]

With `before`, once more as it was before cloth was given friction, more passes of contact and a
coarse double of the body to lie on: times on a shared machine compare within one run only.
"""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack
from unittest import mock

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import Body
from w2w.core.body.skeleton import JOINT_INDEX, N_JOINTS
from w2w.core.garments.cover import Cover, cover
from w2w.core.garments.cut import cut
from w2w.core.garments.on_cloth import ClothSensors
from w2w.core.garments.run_up import with_run_up
from w2w.core.imu.synthesis import synthesize
from w2w.core.motion.motion import Motion
from w2w.core.patches.patches import PatchSet, sample_patches
from w2w.scene.garments.bake import followed

FRAMES, RATE, ARM_DOWN = 20, 60.0, 70

BEFORE = {"cloth.FRICTION": 5.0, "cloth.COLLISION_STEPS": 2, "cloth.COARSE_FACES": 10**9}


def main() -> None:
    """Print it."""
    kind = "trousers" if "trousers" in sys.argv else "tshirt"
    body = Body.bundled()
    cloth = cut(kind, body).cloth
    patches = sample_patches(body, 128)
    own = cover(cloth.vertices, cloth.faces, body, patches)
    still = _standing(body)
    print(
        f"{kind}, {len(own)} sensors, {FRAMES} frames; RMS acceleration, m/s2: median, 95th percentile, most"
    )
    show("as it is", {}, body, patches, kind, own, still)
    if "before" in sys.argv:
        show("as it was", BEFORE, body, patches, kind, own, still)


def show(
    title: str,
    settings: dict[str, float],
    body: Body,
    patches: PatchSet,
    kind: str,
    own: Cover,
    still: Motion,
) -> None:
    """Print what settings give."""
    with ExitStack() as stack:
        for name, value in settings.items():
            stack.enter_context(mock.patch(f"w2w.scene.garments.{name}", value))
        begun = time.process_time()
        worn = followed(body, patches, {kind: own}, still)
        spent = (time.process_time() - begun) / with_run_up(still)[0].n_frames
    path = worn.matrices[:, :, :3, 3]
    raw = np.linalg.norm(np.diff(path, 2, axis=0), axis=2) * RATE**2
    for what, sizes in (("not filtered", raw), ("below 10 Hz, as signals are", _in_band(worn))):
        rms = np.sqrt((sizes**2).mean(axis=0))
        print(f"{title}, {what}: {np.median(rms):.2f}, {np.percentile(rms, 95):.2f}, {rms.max():.2f}")
    print(f"{title}: {1000 * spent:.0f} ms of the processor a frame")


def _standing(body: Body) -> Motion:
    rotations = np.tile(np.eye(3), (FRAMES, N_JOINTS, 1, 1))
    for side, angle in (("left", ARM_DOWN), ("right", -ARM_DOWN)):
        turn = Rotation.from_euler("y", angle, degrees=True).as_matrix()
        rotations[:, JOINT_INDEX[f"{side}_shoulder"]] = turn
    return Motion(rotations, np.tile(body.joints[0], (FRAMES, 1)), RATE)


def _in_band(worn: ClothSensors) -> np.ndarray:
    """How far what the sensors feel is from its mean, (T, K)."""
    acc = synthesize(worn.matrices, worn.rate).acc.astype(float)
    return np.linalg.norm(acc - acc.mean(axis=0), axis=2)


if __name__ == "__main__":
    main()
