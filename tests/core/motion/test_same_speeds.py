# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies on other rigs, larger, backwards or on other legs are known by their speeds; repetitions are not."""

import tarfile
from itertools import combinations

import numpy as np
import pytest

from w2w.api.loading import load
from w2w.core.motion.same_speeds import same_speeds
from w2w.core.motion.signature import WIDTH, motion_signature
from w2w_studies.commands.study_copies import KINDS, backwards, cut, larger, on_another_rig
from w2w_studies.sweep.augmentation import mirrored

from ...exercises import exercises
from ...rings import by_day

HIDDEN = (
    "larger by 15 %",
    "joints turned by 20 degrees",
    "backwards",
    "on another's legs",
    "smaller by 20 %",
)


def pairs_among(motions):
    signatures = [motion_signature(motion) for motion in motions]
    frames = np.array([len(signature) // WIDTH for signature in signatures])
    found = same_speeds(signatures, np.arange(len(motions)), frames, lambda *_: False)
    return {tuple(sorted(pair)) for pair in found}


@pytest.fixture(scope="module")
def demo():
    return list(exercises(4).values())


@pytest.mark.later
@pytest.mark.parametrize("kind", by_day(HIDDEN[:2], HIDDEN))
def test_hidden_copies_are_found_and_repetitions_stay_apart(demo, kind):
    rng = np.random.default_rng(3)
    copies = [KINDS[kind](motion, demo[n - 7], rng) for n, motion in enumerate(demo)]
    pairs = pairs_among([*demo, *copies])
    assert np.mean([(n, n + len(demo)) in pairs for n in range(len(demo))]) >= 0.9
    assert not {pair for pair in combinations(range(len(demo)), 2) if pair in pairs}


def test_a_copy_is_found_whatever_was_done_to_it_at_once(demo):
    rng = np.random.default_rng(0)
    motion = demo[0]
    copy = on_another_rig(larger(backwards(mirrored(cut(motion, 0.2, rng))), 1.2), 25, rng)
    assert pairs_among([motion, demo[1], copy]) == {(0, 2)}


def test_clips_that_hardly_move_are_no_copies(demo):
    still = [larger(motion, 1e-3) for motion in demo[:3]]
    assert pairs_among([*still, *still]) == set()
    assert pairs_among(still[:1]) == set()


@pytest.mark.slow
@pytest.mark.parametrize("library", ["hdm05", "bandai_namco"])
def test_no_repetition_of_real_people_is_called_a_copy(shared_data, tmp_path, library):
    with tarfile.open(shared_data / "library" / f"{library}.tar.xz") as archive:
        archive.extractall(tmp_path, filter="data")
    assert pairs_among(load(tmp_path)) == set()
