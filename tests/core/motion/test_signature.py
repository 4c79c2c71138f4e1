# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of a motion are known however they were cut, resampled, hurried or mirrored; repetitions are not."""

import contextlib
import csv
import re
from dataclasses import replace
from itertools import combinations
from pathlib import PurePosixPath

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.api.loading import load
from w2w.core.body.body import Body
from w2w.core.motion.examples import demo_motions
from w2w.core.motion.motion import at_rate
from w2w.core.motion.signature import WIDTH, mirrored_poses, motion_signature
from w2w.core.ranking.utility import utility_map
from w2w.core.reading import reader
from w2w.core.study.clip_files import ClipWindows
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import LabelledClip, WindowLabels, same_motion_groups, same_motions
from w2w.core.study.signals import describe, place_patches, simulate
from w2w_studies.sweep.augmentation import at_tempo, mirrored, scaled

from ...rings import by_day


def poses_of(motion):
    return motion_signature(motion).reshape(-1, WIDTH)


def part(motion, start, end):
    """The frames between two shares of the clip."""
    frames = slice(round(start * motion.n_frames), round(end * motion.n_frames))
    return replace(motion, rotations=motion.rotations[frames], pelvis=motion.pelvis[frames])


def noisy(motion, degrees, seed=0):
    vectors = np.radians(degrees) * np.random.default_rng(seed).normal(size=(motion.n_frames * 24, 3))
    noise = Rotation.from_rotvec(vectors).as_matrix().reshape(motion.rotations.shape)
    return replace(motion, rotations=motion.rotations @ noise)


def in_a_row(first, second):
    return replace(
        first,
        rotations=np.concatenate([first.rotations, second.rotations]),
        pelvis=np.concatenate([first.pelvis, second.pelvis]),
    )


def elsewhere(motion):
    """The motion, facing and standing elsewhere."""
    turn = Rotation.from_euler("z", 130, degrees=True).as_matrix()
    rotations = motion.rotations.copy()
    rotations[:, 0] = turn @ rotations[:, 0]
    return replace(motion, rotations=rotations, pelvis=motion.pelvis @ turn.T + 3.0)


KINDS = {
    "cut by 5 %": lambda motion, _: part(motion, 0.05, 1),
    "cut by a third": lambda motion, _: part(motion, 0, 0.66),
    "halved": lambda motion, _: part(motion, 0.5, 1),
    "in a row": lambda motion, other: in_a_row(other, motion),
    "2 degrees of noise": lambda motion, _: noisy(motion, 2),
    "24 frames a second": lambda motion, _: at_rate(motion, 24),
    "60 frames a second": lambda motion, _: at_rate(motion, 60),
    "5 % faster": lambda motion, _: at_tempo(motion, 1.05),
    "3 % slower": lambda motion, _: at_tempo(motion, 0.97),
    "mirrored elsewhere": lambda motion, _: mirrored(elsewhere(motion)),
    "several": lambda motion, _: noisy(at_tempo(mirrored(part(motion, 0.3, 1)), 0.96), 1),
}


SLOW = "arm_raise_band"
"""Slow exercises guided by a band: halves of some are as near to others as copies on other rigs."""


@pytest.fixture(scope="module")
def demo():
    """The demo's motions: 12 clips of each activity, real ones."""
    return list(demo_motions().values())


@pytest.mark.later
@pytest.mark.parametrize("kind", by_day(("halved", "in a row"), KINDS))
def test_copies_are_found_and_originals_stay_apart(demo, kind):
    some = demo[::2] if kind.endswith("a second") else demo  # splines through every joint take long
    copies = [KINDS[kind](motion, some[n - 7]) for n, motion in enumerate(some)]
    groups = np.array(groups_of([*some, *copies]))
    found = groups[len(some) :] == groups[: len(some)]
    assert found.mean() >= 0.95
    if kind != "in a row":  # which joins two
        apart = [groups[n] for n, motion in enumerate(some) if motion.activity != SLOW]
        assert len(set(apart)) == len(apart)


def f1_by_chance(motions, labels):
    """Mean F1 of six patches in a cross-validation by motions as they are found, labels given."""
    config = StudyConfig(sensor="ideal", patches=6)
    body = Body.bundled()
    patches = place_patches(body, config)
    windows = [describe(simulate(body, patches, motion, config), config) for motion in motions]
    found = [ClipWindows(test, motion_signature(m)) for (_, test), m in zip(windows, motions, strict=True)]
    clips = [LabelledClip(str(n), label) for n, label in enumerate(labels)]
    protocol = WindowLabels.of(same_motions(clips, found), found).protocol(config)
    return utility_map(np.concatenate([features for features, _ in windows]), protocol).mean.max()


@pytest.mark.slow
def test_labels_dealt_by_chance_stay_at_chance_whatever_the_copies(demo):
    """Four copies of each motion, cut, hurried, mirrored or noisy: F1 would near 1 if they were not found."""
    originals = demo[::4] + demo[2::4]
    labels = np.random.default_rng(0).permutation(np.repeat(list("abcd"), len(originals) // 4)).tolist()
    several = [
        lambda motion: part(motion, 0.2, 1),
        lambda motion: noisy(part(motion, 0, 0.75), 1),
        lambda motion: at_tempo(part(motion, 0.1, 1), 1.04),
        lambda motion: mirrored(part(motion, 0, 0.9)),
    ]
    copies = [copy(motion) for copy in several for motion in originals]
    alone = f1_by_chance(originals, labels)
    assert f1_by_chance(originals + copies, labels * 5) <= alone + 0.1


def test_the_mirrored_signature_is_that_of_the_mirrored_motion(waving):
    found = mirrored_poses(poses_of(waving))
    np.testing.assert_allclose(found, poses_of(mirrored(waving)), atol=1e-3)
    np.testing.assert_array_equal(mirrored_poses(found), poses_of(waving))


def test_signatures_are_of_time_not_of_frames(waving):
    """Ends included: those of a cut clip are as they are inside the whole."""
    whole = poses_of(waving)
    np.testing.assert_allclose(poses_of(at_rate(waving, 2 * waving.rate)), whole, atol=2e-2)
    frames = round(waving.rate)
    late = replace(waving, rotations=waving.rotations[frames:], pelvis=waving.pelvis[frames:])
    np.testing.assert_allclose(poses_of(late), whole[20:], atol=6e-2)
    np.testing.assert_array_equal(poses_of(elsewhere(waving)), whole)


def test_a_single_frame_has_a_signature(waving):
    still = replace(waving, rotations=waving.rotations[:1], pelvis=waving.pelvis[:1])
    np.testing.assert_allclose(poses_of(still), poses_of(waving)[:1], atol=0.2)


def test_a_mirrored_or_larger_download_is_the_same_motion_and_another_pace_is_not(waving):
    motions = [waving, scaled(waving, 0.5), mirrored(waving), replace(waving, pelvis=waving.pelvis + 1.0)]
    assert groups_of([*motions, at_tempo(waving, 2)]) == [0, 0, 0, 0, 1]


@pytest.mark.parametrize("clips", [1, 2])
def test_few_clips_are_grouped_too(waving, clips):
    assert groups_of([waving] * clips) == [0] * clips


def groups_of(motions):
    signatures = [motion_signature(motion) for motion in motions]
    return same_motion_groups([str(n) for n in range(len(motions))], [""] * len(motions), signatures).tolist()


@pytest.fixture(scope="module")
def mixamo(shared_data):
    """Real downloads by the names of their files, read here: a worker takes seconds to start."""
    pytest.importorskip("bpy")
    folder = shared_data / "mixamo"

    def read(*files):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(reader, "RISKY", ())
            return [load(folder / file)[0] for file in files]

    return read


STRANGERS = (
    "kirbycope__godot-4.3-sandbox-3d/Crouching_Idle.fbx",
    "M3-org__CharacterStudio/AirSquat.fbx",
    "M3-org__CharacterStudio/StandingGreeting.fbx",
    "kirbycope__godot-4.3-sandbox-3d/Kicking_Left.fbx",
    "Conqster__TheBarMan/Walking.fbx",
)


@pytest.mark.slow
@pytest.mark.later
def test_whoever_nods_does_not_shake_the_head(mixamo):
    nod, shake, *others = mixamo(
        "junlinwk__Unity-MR-XR-AI-Agent-Avatar/Head Nod Yes.fbx",
        "lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Stroke Shaking Head.fbx",
        *STRANGERS,
    )
    shaken = replace(shake, rate=shake.rate * shake.duration / nod.duration)
    as_still = replace(nod, rotations=nod.rotations.copy())
    turn = Rotation.from_rotvec(0.2 * np.sin(np.linspace(0, 9, nod.n_frames))[:, None] * [0.0, 0.0, 1.0])
    as_still.rotations[:, 15] = turn.as_matrix()
    assert groups_of([nod, shaken, as_still, *others]) == list(range(3 + len(others)))


@pytest.mark.later
def test_real_copies_are_known(mixamo):
    """At 30 and 60 frames a second, on other rigs, in place, mirrored."""
    pairs = (
        ("murpysn__CobaPlayground/aj@Walking.fbx",
         "M3-org__CharacterStudio/Walking.fbx"),
        ("kirbycope__godot-4.3-sandbox-3d/Walking_InPlace.fbx", "Conqster__TheBarMan/Walking.fbx"),
        ("kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx",
         "Conv-AI__ThreeJs-World-Tutorial/Running.fbx"),
        ("kirbycope__godot-4.3-sandbox-3d/Kicking_Left.fbx",
         "kirbycope__godot-4.3-sandbox-3d/Kicking_Right.fbx"),
        ("kirbycope__godot-4.3-sandbox-3d/Crouching_Idle.fbx",) * 2,
    )  # fmt: skip
    groups = groups_of(mixamo(*(file for pair in pairs for file in pair)))
    assert groups == [number for number in range(len(pairs)) for _ in range(2)]


OF_A_COPY = "^aj@|_InPlace|Left|Right|[_ ]"
"""What the names of copies differ by."""


@pytest.mark.slow
def test_of_all_real_motions_only_downloads_of_one_are_one(shared_data):
    """7 of 11 pairs of one motion_key are found; the others join copies that the keys do not know."""
    pytest.importorskip("bpy")
    rows, motions = [], []
    with (shared_data / "motions.csv").open(newline="", encoding="utf-8") as stream:
        for row in csv.DictReader(stream):
            with contextlib.suppress(ValueError):
                motions.append(load(shared_data / row["file"])[0])
                rows.append(
                    (re.sub(OF_A_COPY, "", PurePosixPath(row["file"]).stem).lower(), row["motion_key"])
                )
    groups = groups_of(motions)
    found = [(a, b) for a, b in combinations(range(len(rows)), 2) if groups[a] == groups[b]]
    by_key = [(a, b) for a, b in found if rows[a][1] == rows[b][1] != ""]
    assert (len(by_key), len(found)) == (7, 24)
    for a, b in found:
        assert rows[a][0] == rows[b][0]


def test_signatures_that_say_nothing_join_no_clips(waving):
    told = motion_signature(waving)
    untold = [np.empty(0)] * 4
    groups = same_motion_groups([str(n) for n in range(6)], ["", "", "k", "k", "", ""], [*untold, told, told])
    assert groups.tolist() == [0, 1, 2, 2, 3, 3]
    assert same_motion_groups(["a", "b"], ["", ""], untold[:2]).tolist() == [0, 1]
