# SPDX-License-Identifier: GPL-3.0-or-later
"""What our T-shirt does on a body that stands still, after the usual run-up, and what a frame takes.

python -m benchmarks.cloth_at_rest
"""

from __future__ import annotations

import time

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import Body
from w2w.core.body.skeleton import JOINT_INDEX, N_JOINTS
from w2w.core.motion.motion import Motion
from w2w.core.motion.run_up import with_run_up
from w2w.core.patches.garment_cover import cover
from w2w.core.patches.garments import cut
from w2w.core.patches.patches import sample_patches
from w2w.scene.wear import worn_through

FRAMES, RATE, ARM_DOWN = 20, 60.0, 70


def main() -> None:
    """Print it."""
    body = Body.bundled()
    patches = sample_patches(body, 128, mode="fast")
    cloth = cut("tshirt", body).cloth
    own = cover(cloth.vertices, cloth.faces, body, patches)
    rotations = np.tile(np.eye(3), (FRAMES, N_JOINTS, 1, 1))
    for side, angle in (("left", ARM_DOWN), ("right", -ARM_DOWN)):
        turn = Rotation.from_euler("y", angle, degrees=True).as_matrix()
        rotations[:, JOINT_INDEX[f"{side}_shoulder"]] = turn
    still = Motion(rotations, np.tile(body.joints[0], (FRAMES, 1)), RATE)
    begun = time.process_time()
    worn = worn_through(body, {"tshirt": own}, still)
    spent = (time.process_time() - begun) / with_run_up(still)[0].n_frames
    path = worn.matrices[:, :, :3, 3]
    acceleration = np.linalg.norm(np.diff(path, 2, axis=0), axis=2) * RATE**2
    rms = np.sqrt((acceleration**2).mean(axis=0))
    print(f"{len(own)} sensors, {FRAMES} frames: RMS acceleration, not filtered, m/s2")
    print(f"median {np.median(rms):.2f}, 95th percentile {np.percentile(rms, 95):.2f}, most {rms.max():.2f}")
    print(f"{1000 * spent:.0f} ms of the processor a frame")


if __name__ == "__main__":
    main()
