# SPDX-License-Identifier: GPL-3.0-or-later
"""Downloads of one motion are known as one, mirrored ones too."""

import contextlib
import csv
import re
from dataclasses import replace
from itertools import combinations
from pathlib import PurePosixPath

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.motion.duplicates import POSES, mirrored_signatures, motion_signature, move_alike
from w2w.core.study import same_clips
from w2w.loading import load
from w2w.studies.sweep.augmentation import at_tempo, mirrored, scaled


def test_the_mirrored_signature_is_that_of_the_mirrored_motion(waving):
    found = mirrored_signatures(motion_signature(waving)[None])[0]
    np.testing.assert_allclose(found, motion_signature(mirrored(waving)), atol=1e-12)
    np.testing.assert_allclose(mirrored_signatures(found[None])[0], motion_signature(waving), atol=1e-12)


def test_of_no_pairs_none_moves_alike():
    none = np.empty((0, len(POSES)), dtype=np.float32)
    assert move_alike(none, none).shape == (0,)


def test_a_mirrored_download_is_the_same_motion_and_another_pace_is_not(waving):
    others = [scaled(waving, factor) for factor in (0.2, 1.9)]
    motions = [
        waving,
        *others,
        mirrored(waving),
        replace(waving, pelvis=waving.pelvis + 1.0),
        at_tempo(waving, 2),
    ]
    signatures = np.array([motion_signature(motion) for motion in motions])
    groups = same_clips([f"clip {n}" for n in range(6)], [""] * 6, signatures)
    assert groups.tolist() == [0, 1, 2, 0, 0, 0]


@pytest.mark.parametrize("clips", [1, 2])
def test_few_clips_are_grouped_too(waving, clips):
    signatures = np.array([motion_signature(waving)] * clips)
    assert same_clips([str(n) for n in range(clips)], [""] * clips, signatures).tolist() == [0] * clips


def groups_of(motions):
    signatures = [motion_signature(motion) for motion in motions]
    return same_clips([str(n) for n in range(len(motions))], [""] * len(motions), signatures).tolist()


@pytest.fixture(scope="module")
def mixamo(shared_data):
    """Real downloads by the names of their files."""
    pytest.importorskip("bpy")
    folder = shared_data / "mixamo"

    def read(*files):
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
def test_whoever_stands_and_nods_is_nobody_else(mixamo):
    """Nods of other lengths and ranges, and a shake of the head as long as the nod."""
    nod, shake, *others = mixamo(
        "junlinwk__Unity-MR-XR-AI-Agent-Avatar/Head Nod Yes.fbx",
        "lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Stroke Shaking Head.fbx",
        *STRANGERS,
    )
    head = ("neck", "head")
    nods = [
        nod,
        *(at_tempo(scaled(nod, to, head), 2.6 / s) for s, to in ((1.6, 1.5), (1.9, 0.7), (2.2, 1.2))),
    ]
    shaken = replace(shake, rate=shake.rate * shake.duration / nod.duration)
    groups = groups_of([*nods, shaken, *others])
    assert groups == list(range(len(groups)))
    as_still = replace(nod, rotations=nod.rotations.copy())
    turn = Rotation.from_rotvec(0.2 * np.sin(np.linspace(0, 9, nod.n_frames))[:, None] * [0.0, 0.0, 1.0])
    as_still.rotations[:, 15] = turn.as_matrix()
    assert groups_of([nod, as_still, *others])[:2] == [0, 1]


@pytest.mark.later
def test_real_copies_are_known(mixamo):
    """At 24 and 30 frames a second, in place, mirrored."""
    pairs = (
        ("M3-org__CharacterStudio/StandingGreeting.fbx",
         "lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Standing Greeting.fbx"),
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
                rows.append((re.sub(OF_A_COPY, "", PurePosixPath(row["file"]).stem), row["motion_key"]))
    groups = groups_of(motions)
    found = [(a, b) for a, b in combinations(range(len(rows)), 2) if groups[a] == groups[b]]
    by_key = [(a, b) for a, b in found if rows[a][1] == rows[b][1] != ""]
    assert (len(by_key), len(found)) == (7, 20)
    for a, b in found:
        assert rows[a][0] == rows[b][0]


def test_signatures_that_say_nothing_join_no_clips(waving):
    told = motion_signature(waving)
    untold = [np.empty(0)] * 4
    groups = same_clips([str(n) for n in range(6)], ["", "", "k", "k", "", ""], [*untold, told, told])
    assert groups.tolist() == [0, 1, 2, 2, 3, 3]
    assert same_clips(["a", "b"], ["", ""], untold[:2]).tolist() == [0, 1]
