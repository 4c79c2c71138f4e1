# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotations from joint positions: how near they come and how long 30 seconds take, on real motion capture.

    python -m benchmarks.keypoints CLIP.npz [--noise 0 0.01 0.02]

The clip (AMASS-style npz) drives the bundled body; its landmarks, with noise along each axis, are all that
`fit_keypoints` sees, as Human3.6M's 17 joints at 30 frames a second. The baseline in the same run takes the
noisy positions as they come: each limb's direction from joint to joint, frame by frame.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import Body
from w2w.core.body.skeleton import JOINT_INDEX
from w2w.core.keypoints.fit import fit_keypoints
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.motion.motion import Motion, read_amass
from w2w.core.motion.skinning import joint_transforms, on_the_ground

HUMAN36M_17 = JOINT_SETS["human36m-17"]

RATE, SECONDS = 30.0, 30.0
STANDS_FOR = {"spine": "spine2", "nose": "head"}
MIDDLES = {"hip": "hip", "thorax": "shoulder"}
LIMBS = tuple(
    (f"{side}_{start}", f"{side}_{end}")
    for side in ("left", "right")
    for start, end in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
)
TURNS = ("hip", "knee", "shoulder", "elbow")


def seen(positions: np.ndarray) -> np.ndarray:
    """The 17 joints from the body's 24, shape (T, 17, 3)."""
    at = lambda name: positions[:, JOINT_INDEX[name]]  # noqa: E731
    return np.stack(
        [
            (at(f"left_{MIDDLES[joint]}") + at(f"right_{MIDDLES[joint]}")) / 2
            if joint in MIDDLES
            else at(STANDS_FOR.get(joint, joint))
            for joint in HUMAN36M_17.joints
        ],
        axis=1,
    )


def directions(at: dict[str, np.ndarray]) -> np.ndarray:
    """Unit direction of each limb segment, (T, 8, 3)."""
    bones = np.stack([at[end] - at[start] for start, end in LIMBS], axis=1)
    return bones / np.linalg.norm(bones, axis=2, keepdims=True)


def degrees(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Angle between unit vectors."""
    return np.degrees(np.arccos(np.clip((first * second).sum(axis=-1), -1, 1)))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("clip", type=Path)
    parser.add_argument("--noise", type=float, nargs="+", default=[0.0, 0.01, 0.02], help="metres")
    options = parser.parse_args()
    body = Body.bundled()
    whole = on_the_ground(body, read_amass(options.clip))
    frames = np.round(np.arange(0, whole.duration, 1 / RATE) * whole.rate).astype(int)
    truth = Motion(whole.rotations[frames], whole.pelvis[frames], RATE)
    turns, positions = joint_transforms(body, truth)
    clean = seen(positions)
    expected = directions({name: positions[:, JOINT_INDEX[name]] for pair in LIMBS for name in pair})
    print(f"{truth.n_frames} frames of {options.clip.name}; degrees, median (95th percentile) over limbs\n")
    print("| noise, mm | plain directions | fitted directions | turn of " + " | ".join(TURNS) + " |")
    print("|" + "---|" * (3 + len(TURNS)))
    for noise in options.noise:
        points = clean + noise * np.random.default_rng(0).normal(size=clean.shape)
        plain = degrees(
            expected, directions(dict(zip(HUMAN36M_17.joints, points.swapaxes(0, 1), strict=True)))
        )
        found = joint_transforms(body, fit_keypoints(points, RATE, HUMAN36M_17, body).motion)
        fitted = degrees(
            expected, directions({n: found[1][:, JOINT_INDEX[n]] for pair in LIMBS for n in pair})
        )
        apart = Rotation.from_matrix((turns.swapaxes(-1, -2) @ found[0]).reshape(-1, 3, 3)).magnitude()
        apart = np.degrees(apart).reshape(turns.shape[:2])
        cells = [f"{np.median(error):.2f} ({np.percentile(error, 95):.1f})" for error in (plain, fitted)]
        cells += [
            f"{np.median(apart[:, [JOINT_INDEX[f'{s}_{part}'] for s in ('left', 'right')]]):.1f}"
            for part in TURNS
        ]
        print(f"| {1000 * noise:g} | " + " | ".join(cells) + " |")
    repeats = int(np.ceil(SECONDS * RATE / len(clean)))
    long = np.concatenate([clean, clean[::-1]] * repeats)[: int(SECONDS * RATE)]
    start = time.perf_counter()
    fit_keypoints(long, RATE, HUMAN36M_17, body)
    print(f"\n{SECONDS:g} s of video in {time.perf_counter() - start:.2f} s")


if __name__ == "__main__":
    main()
