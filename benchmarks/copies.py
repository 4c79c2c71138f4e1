# SPDX-License-Identifier: GPL-3.0-or-later
"""Share of copies that are found, by kind, and what else is merged.

    python -m benchmarks.copies LIBRARY [--every 1]
    python -m benchmarks.copies LIBRARY --chance

One copy of every clip of each kind is put beside the originals. Clips below half a second are left out.
With --chance, labels are dealt by chance to 36 clips, alone and with three copies each, cut by 10 to 34 %:
F1 stays that of chance only where no clip is tested on its copy.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from w2w import Body, load, rank, sample_patches, synthesize
from w2w.core.motion.duplicates import motion_signature
from w2w.core.motion.motion import Motion, at_rate
from w2w.core.ranking.same_motion import same_motion_groups
from w2w.studies.sweep.augmentation import at_tempo, mirrored

RNG = np.random.default_rng(0)


def cut(motion: Motion, share: float) -> Motion:
    """The motion without this share of its frames, at either end."""
    off = round(motion.n_frames * share)
    kept = slice(off, None) if RNG.integers(2) else slice(0, motion.n_frames - off)
    return replace(motion, rotations=motion.rotations[kept], pelvis=motion.pelvis[kept])


def noisy(motion: Motion, degrees: float) -> Motion:
    """Each joint turned at random in each frame, by so much about each axis."""
    vectors = np.radians(degrees) * RNG.normal(size=(motion.n_frames * 24, 3))
    noise = Rotation.from_rotvec(vectors).as_matrix().reshape(motion.rotations.shape)
    return replace(motion, rotations=motion.rotations @ noise)


KINDS = {
    "cut by 5 %": lambda m: cut(m, 0.05),
    "cut by 10 to 34 %": lambda m: cut(m, RNG.uniform(0.1, 0.34)),
    "halved": lambda m: cut(m, 0.5),
    "1 degree of noise": lambda m: noisy(m, 1),
    "2 degrees of noise": lambda m: noisy(m, 2),
    "24 frames a second": lambda m: at_rate(m, 24),
    "30 frames a second": lambda m: at_rate(m, 30),
    "5 % faster": lambda m: at_tempo(m, 1.05),
    "mirrored": mirrored,
    "cut, 30 frames a second, 2 degrees": lambda m: noisy(at_rate(cut(m, RNG.uniform(0.1, 0.34)), 30), 2),
    "halved, 24 frames, mirrored, 5 % slower, 1 degree": (
        lambda m: noisy(at_tempo(mirrored(at_rate(cut(m, 0.5), 24)), 0.95), 1)
    ),
}


def groups_of(motions: list[Motion]) -> list[int]:
    """The number of each clip's motion."""
    signatures = [motion_signature(motion) for motion in motions]
    return same_motion_groups([str(n) for n in range(len(motions))], [""] * len(motions), signatures).tolist()


def by_chance(motions: list[Motion]) -> None:
    """Print the F1 of labels dealt by chance, of clips alone and with copies."""
    patches = sample_patches(Body.bundled(), 24)
    for draw in range(3):
        rng = np.random.default_rng(draw)
        drawn = rng.choice([n for n, m in enumerate(motions) if m.duration >= 1.5], 36, replace=False)
        alone = [motions[n].labelled("abc"[rng.integers(3)], "", f"clip {n}") for n in drawn]
        copies = [
            cut(m, rng.uniform(0.1, 0.34)).labelled(m.activity, "", f"{m.clip} {k}")
            for m in alone
            for k in range(3)
        ]
        best = [
            rank(synthesize(made, patches, sensor="bmi270")).mean.max() for made in (alone, alone + copies)
        ]
        print(f"draw {draw}: best of 24 patches {best[0]:.2f} alone, {best[1]:.2f} with copies", flush=True)


def main() -> None:
    """Read the library and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("library", type=Path)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--chance", action="store_true")
    choice = parser.parse_args()
    motions = [motion for motion in load(choice.library) if motion.duration >= 0.5][:: choice.every]
    if choice.chance:
        by_chance(motions)
        return
    groups = groups_of(motions)
    print(f"{len(motions)} clips, {len(set(groups))} motions")
    for number in sorted(n for n in set(groups) if groups.count(n) > 1):
        print("  one motion:", *(m.clip for m, group in zip(motions, groups, strict=True) if group == number))
    for kind, make in KINDS.items():
        copies = [(n, copy) for n, m in enumerate(motions) if (copy := make(m)).duration >= 0.5]
        found = groups_of([*motions, *(copy for _, copy in copies)])
        share = np.mean([found[n] == found[len(motions) + k] for k, (n, _) in enumerate(copies)])
        print(f"{kind:50s} {share:.3f} of {len(copies)}", flush=True)


if __name__ == "__main__":
    main()
