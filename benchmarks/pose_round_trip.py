# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions seen as the joints of each set and fitted again: errors of angles, and how far the maps agree.

    python -m benchmarks.pose_round_trip CLIP.npz [--library FOLDER --labels labels.csv] [--noise 0.01]

CLIP is an AMASS-style npz: its errors are degrees between the world rotations of the segments, at 30 frames a
second. The motions of FOLDER are ranked as they are and as each set shows them, by the same folds.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import spearmanr

import w2w
from tests.seen_joints import seen_as
from w2w.core.body.body import Body
from w2w.core.body.skeleton import JOINT_INDEX, N_JOINTS
from w2w.core.keypoints.fit import fit_keypoints
from w2w.core.keypoints.joint_sets import JOINT_SETS, JointSet
from w2w.core.motion.motion import Motion, read_amass
from w2w.core.motion.skinning import joint_transforms, on_the_ground

RATE = 30.0
PARTS = ("pelvis", "spine3", "head", "shoulder", "elbow", "wrist", "hip", "knee", "ankle")
PLACES = 96


def fitted(motion: Motion, joint_set: JointSet, body: Body, noise: float) -> Motion:
    """The motion as it comes back from the joints that the set has."""
    points = seen_as(joint_set, body, motion)
    points = points + noise * np.random.default_rng(0).normal(size=points.shape)
    found = fit_keypoints(points, motion.rate, joint_set, body).motion
    return found.labelled(motion.activity, motion.subject, motion.clip)


def degrees(first: Motion, second: Motion, body: Body) -> np.ndarray:
    """Angle between the segments' world rotations, shape (T, 24)."""
    a, b = (joint_transforms(body, motion)[0] for motion in (first, second))
    turns = (a.swapaxes(-1, -2) @ b).reshape(-1, 3, 3)
    return np.degrees(Rotation.from_matrix(turns).magnitude()).reshape(-1, N_JOINTS)


def angles(clip: Path, body: Body, noise: float) -> None:
    """Print the errors of each set on one clip."""
    whole = on_the_ground(body, read_amass(clip))
    frames = np.round(np.arange(0, whole.duration, 1 / RATE) * whole.rate).astype(int)
    truth = Motion(whole.rotations[frames], whole.pelvis[frames], RATE)
    print(f"{truth.n_frames} frames of {clip.name}, {1000 * noise:g} mm of noise; degrees, median (95th)\n")
    print("| joint set | " + " | ".join(PARTS) + " |\n|" + "---|" * (1 + len(PARTS)))
    for name, joint_set in JOINT_SETS.items():
        error = degrees(truth, fitted(truth, joint_set, body, noise), body)
        cells = []
        for part in PARTS:
            columns = [JOINT_INDEX[p] for p in (part, f"left_{part}", f"right_{part}") if p in JOINT_INDEX]
            found = error[:, columns]
            cells.append(f"{np.median(found):.1f} ({np.percentile(found, 95):.0f})")
        print(f"| {name} | " + " | ".join(cells) + " |")


def maps(library: Path, labels: Path | None, body: Body, noise: float) -> None:
    """Print how far the map of each set agrees with that of the motions themselves."""
    motions = w2w.load(library, body, labels)
    patches = w2w.sample_patches(body, PLACES)

    def ranked(found: tuple[Motion, ...], seed: int = 0) -> np.ndarray:
        signals = w2w.synthesize(replace(motions, motions=found), patches, seed=seed)
        return w2w.rank(signals).utility.mean

    usual = ranked(motions.motions)
    print(f"\n{len(motions)} clips, {PLACES} places, mean F1 {usual.mean():.3f}, best {usual.max():.3f}\n")
    print("| joint set | Spearman's rho | mean F1 | F1 of its best place in the map of the motions |")
    print("|---|---|---|---|")
    again = ranked(motions.motions, seed=1)
    rho = spearmanr(usual, again).statistic
    print(
        f"| the motions, other sensor noise | {rho:.2f} | {again.mean():.3f} | {usual[again.argmax()]:.3f} |"
    )
    for name, joint_set in JOINT_SETS.items():
        scores = ranked(tuple(fitted(motion, joint_set, body, noise) for motion in motions))
        rho = spearmanr(usual, scores).statistic
        print(f"| {name} | {rho:.2f} | {scores.mean():.3f} | {usual[scores.argmax()]:.3f} |", flush=True)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("clip", type=Path)
    parser.add_argument("--library", type=Path)
    parser.add_argument("--labels", type=Path)
    parser.add_argument("--noise", type=float, default=0.01, help="metres along each axis")
    options = parser.parse_args()
    body = Body.bundled()
    angles(options.clip, body, options.noise)
    if options.library:
        maps(options.library, options.labels, body, options.noise)


if __name__ == "__main__":
    main()
