# SPDX-License-Identifier: GPL-3.0-or-later
"""SciPy's BLAS (`core.blas.multiply`) against `np.matmul`, where a motion is turned to signals and features.

    python -m benchmarks.blas_speed [native | Prescott]

"Prescott" has NumPy's OpenBLAS, and it alone, take the processor for the oldest it knows, as an old one does
with processors made since. Processor seconds on one thread, best of several repeats in turn.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable

KERNELS = sys.argv[1] if len(sys.argv) > 1 else "native"
if KERNELS != "native":
    os.environ["OPENBLAS_CORETYPE"] = KERNELS
import numpy as np  # noqa: E402 - it reads the variable as it is loaded

os.environ.pop("OPENBLAS_CORETYPE", None)
from threadpoolctl import threadpool_info, threadpool_limits  # noqa: E402

from w2w.core import blas  # noqa: E402
from w2w.core.body.body import N_JOINTS, Body  # noqa: E402
from w2w.core.imu import synthesis  # noqa: E402
from w2w.core.imu.virtual import record_motion  # noqa: E402
from w2w.core.motion import skinning  # noqa: E402
from w2w.core.motion.motion import Motion  # noqa: E402
from w2w.core.patches.patches import sample_patches  # noqa: E402
from w2w.core.windows import features  # noqa: E402
from w2w.core.windows.windows import WindowSpec, cut_windows  # noqa: E402

REPEATS = 5
USERS = (synthesis, skinning, features)


def jobs() -> dict[str, Callable[[], object]]:
    """Twenty seconds of motion on 512 patches, to signals and from there to features."""
    body = Body.bundled()
    patches = sample_patches(body, 512)
    rotations = np.broadcast_to(np.eye(3), (600, N_JOINTS, 3, 3)).copy()
    motion = Motion(rotations, np.zeros((600, 3)), 30.0)
    settings = synthesis.Synthesis(rate_hz=50)
    recording = record_motion(body, patches, motion, settings)
    windows = cut_windows(recording, WindowSpec()).signals
    return {
        "motion to signals": lambda: record_motion(body, patches, motion, settings),
        "signals to features": lambda: features.window_features(windows, 50.0),
    }


def main() -> None:
    """Print processor seconds of both ways."""
    print([(found["version"], found.get("architecture")) for found in threadpool_info()])
    with threadpool_limits(1):
        for name, job in jobs().items():
            best = {}
            for _ in range(REPEATS):
                for way, product in (("scipy", blas.multiply), ("numpy", np.matmul)):
                    for user in USERS:
                        user.multiply = product
                    start = time.process_time()
                    job()
                    best[way] = min(best.get(way, np.inf), time.process_time() - start)
            ratio = best["numpy"] / best["scipy"]
            print(f"{name}: scipy {best['scipy']:.3f} s, numpy {best['numpy']:.3f} s, {ratio:.2f} times")


if __name__ == "__main__":
    main()
