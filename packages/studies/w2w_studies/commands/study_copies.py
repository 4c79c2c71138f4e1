# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study copies`: the share of copies of a library's motions that is found, by kind."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from scipy.spatial.transform import Rotation

from w2w import Body, load, rank, sample_patches, synthesize
from w2w.core.body.body import JOINT_INDEX
from w2w.core.motion.motion import Motion, at_rate
from w2w.core.motion.signature import motion_signature
from w2w.core.study.ranking import same_motion_groups
from w2w.headless.console import USAGE, ending

from ..sweep.augmentation import at_tempo, mirrored
from .consoles import wide_console

SHORTEST_S = 0.5
"""Shorter clips and copies are left out."""

DRAWN, COPIES, LONG_S, PATCHES = 36, 3, 1.5, 24
"""Clips whose labels are dealt by chance, copies of each, how long they last, and patches that are ranked."""

LEG = ("hip", "knee", "ankle", "foot")

Draw = np.random.Generator


def cut(motion: Motion, share: float, rng: Draw) -> Motion:
    """The motion without this share of its frames, at either end."""
    off = round(motion.n_frames * share)
    kept = slice(off, None) if rng.integers(2) else slice(0, motion.n_frames - off)
    return replace(motion, rotations=motion.rotations[kept], pelvis=motion.pelvis[kept])


def noisy(motion: Motion, degrees: float, rng: Draw) -> Motion:
    """Each joint turned at random in each frame, by so much about each axis."""
    vectors = np.radians(degrees) * rng.normal(size=(motion.n_frames * 24, 3))
    noise = Rotation.from_rotvec(vectors).as_matrix().reshape(motion.rotations.shape)
    return replace(motion, rotations=motion.rotations @ noise)


def larger(motion: Motion, factor: float) -> Motion:
    """Each joint's turns from its mean pose, larger by a factor."""
    rotations = motion.rotations.copy()
    for joint in range(1, rotations.shape[1]):
        turns = Rotation.from_matrix(rotations[:, joint])
        mean = turns.mean()
        away = Rotation.from_rotvec(factor * (mean.inv() * turns).as_rotvec())
        rotations[:, joint] = (mean * away).as_matrix()
    return replace(motion, rotations=rotations)


def on_another_rig(motion: Motion, degrees: float, rng: Draw) -> Motion:
    """Each joint turned by so much about an axis that stays, as with another rest pose."""
    axes = rng.normal(size=(motion.rotations.shape[1] - 1, 3))
    axes *= np.radians(degrees) / np.linalg.norm(axes, axis=1, keepdims=True)
    rotations = motion.rotations.copy()
    rotations[:, 1:] = rotations[:, 1:] @ Rotation.from_rotvec(axes).as_matrix()
    return replace(motion, rotations=rotations)


def backwards(motion: Motion) -> Motion:
    """The motion from its end to its start."""
    return replace(motion, rotations=motion.rotations[::-1].copy(), pelvis=motion.pelvis[::-1].copy())


def on_legs_of(motion: Motion, other: Motion) -> Motion:
    """The motion with the legs of another, which starts again where it is shorter."""
    rotations, other = motion.rotations.copy(), at_rate(other, motion.rate)
    legs = [JOINT_INDEX[f"{side}_{joint}"] for side in ("left", "right") for joint in LEG]
    rotations[:, legs] = other.rotations[np.arange(motion.n_frames) % other.n_frames][:, legs]
    return replace(motion, rotations=rotations)


def in_a_row(first: Motion, second: Motion) -> Motion:
    """The first motion and then the second, at the rate of the first."""
    both = (first, at_rate(second, first.rate))
    rotations, pelvis = (np.concatenate([getattr(m, part) for m in both]) for part in ("rotations", "pelvis"))
    return replace(first, rotations=rotations, pelvis=pelvis)


KINDS: dict[str, Callable[[Motion, Motion, Draw], Motion]] = {
    "cut by 5 %": lambda m, _, rng: cut(m, 0.05, rng),
    "cut by 10 to 34 %": lambda m, _, rng: cut(m, rng.uniform(0.1, 0.34), rng),
    "halved": lambda m, _, rng: cut(m, 0.5, rng),
    "two in a row": lambda m, other, _: in_a_row(m, other),
    "1 degree of noise": lambda m, _, rng: noisy(m, 1, rng),
    "2 degrees of noise": lambda m, _, rng: noisy(m, 2, rng),
    "24 frames a second": lambda m, *_: at_rate(m, 24),
    "30 frames a second": lambda m, *_: at_rate(m, 30),
    "5 % faster": lambda m, *_: at_tempo(m, 1.05),
    "15 % faster": lambda m, *_: at_tempo(m, 1.15),
    "30 % faster": lambda m, *_: at_tempo(m, 1.3),
    "mirrored": lambda m, *_: mirrored(m),
    "larger by 15 %": lambda m, *_: larger(m, 1.15),
    "smaller by 20 %": lambda m, *_: larger(m, 0.8),
    "joints turned by 20 degrees": lambda m, _, rng: on_another_rig(m, 20, rng),
    "backwards": lambda m, *_: backwards(m),
    "on another's legs": lambda m, other, _: on_legs_of(m, other),
    "cut, 30 frames a second, 2 degrees": (
        lambda m, _, rng: noisy(at_rate(cut(m, rng.uniform(0.1, 0.34), rng), 30), 2, rng)
    ),
    "halved, 24 frames, mirrored, 5 % slower, 1 degree": (
        lambda m, _, rng: noisy(at_tempo(mirrored(at_rate(cut(m, 0.5, rng), 24)), 0.95), 1, rng)
    ),
}


def copies(
    library: Annotated[Path, typer.Argument(metavar="LIBRARY", help="Folder of motion files.")],
    chance: Annotated[
        bool, typer.Option("--chance", help="Deal labels by chance, with copies and without.")
    ] = False,
) -> None:
    """Add one copy of every clip to the originals, kind by kind, and print the share that is found.

    With --chance, labels are dealt by chance to 36 clips, alone and with three copies each, cut by 10 to
    34 %: F1 stays that of chance only where no clip is tested on its copy.

    Exit codes: 0 printed, 2 wrong use.
    """
    console = wide_console()
    with ending(USAGE, console):
        motions = [motion for motion in load(library) if motion.duration >= SHORTEST_S]
        for line in by_chance(motions) if chance else by_kind(motions):
            console.print(line)


def by_kind(motions: list[Motion]) -> Iterator[str]:
    """Clips and motions, those that are one motion as they are, and the share of each kind, in lines."""
    groups, rng = _groups_of(motions), np.random.default_rng(0)
    yield f"{len(motions)} clips, {len(set(groups))} motions"
    for number in sorted(n for n in set(groups) if groups.count(n) > 1):
        yield f"  one motion: {' '.join(m.clip for m, g in zip(motions, groups, strict=True) if g == number)}"
    for kind, make in KINDS.items():
        made = [(n, make(m, motions[n - 1], rng)) for n, m in enumerate(motions)]
        made = [(n, copy) for n, copy in made if copy.duration >= SHORTEST_S]
        found = _groups_of([*motions, *(copy for _, copy in made)])
        share = np.mean([found[n] == found[len(motions) + k] for k, (n, _) in enumerate(made)])
        yield f"{kind:50s} {share:.3f} of {len(made)}"


def by_chance(motions: list[Motion]) -> Iterator[str]:
    """The highest F1 of labels dealt by chance, of clips alone and with copies, a line a draw."""
    patches, of_cuts = sample_patches(Body.bundled(), PATCHES), np.random.default_rng(0)
    long = [number for number, motion in enumerate(motions) if motion.duration >= LONG_S]
    if len(long) < DRAWN:
        raise ValueError(f"--chance needs {DRAWN} clips of {LONG_S:g} s or more; there are {len(long)}")
    for draw in range(3):
        rng = np.random.default_rng(draw)
        drawn = rng.choice(long, DRAWN, replace=False)
        alone = [motions[n].labelled("abc"[rng.integers(3)], "", f"clip {n}") for n in drawn]
        more = [
            cut(m, rng.uniform(0.1, 0.34), of_cuts).labelled(m.activity, "", f"{m.clip} {k}")
            for m in alone
            for k in range(COPIES)
        ]
        best = [rank(synthesize(made, patches, sensor="bmi270")).mean.max() for made in (alone, alone + more)]
        yield f"draw {draw}: best of {PATCHES} patches {best[0]:.2f} alone, {best[1]:.2f} with copies"


def _groups_of(motions: list[Motion]) -> list[int]:
    """The number of each clip's motion."""
    signatures = [motion_signature(motion) for motion in motions]
    return same_motion_groups([str(n) for n in range(len(motions))], [""] * len(motions), signatures).tolist()
