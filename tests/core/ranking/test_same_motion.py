# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips of one and the same motion are found by name, key or a shared stretch, and others are not."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.ndimage import gaussian_filter1d

from w2w.core.motion import shared_stretches, signature
from w2w.core.motion.signature import WIDTH, mirrored_poses
from w2w.core.study.ranking import same_motion_groups


def made_poses(rng, frames=80):
    """Smooth poses that move by .15 in about half a second."""
    poses = gaussian_filter1d(rng.normal(size=(frames + 20, WIDTH)), 5.0, axis=0)[10:-10]
    return poses * (0.15 / poses.std())


def as_signature(poses):
    return poses.astype(np.float16).ravel()


def groups_of(poses, keys=None):
    return same_motion_groups([str(n) for n in range(len(poses))], keys, [as_signature(p) for p in poses])


def test_one_motion_is_one_group_by_name_key_or_stretch_and_by_chain():
    clips = ["a", "b", "c", "d", "e", "a", "f"]
    keys = ["k1", "k2", "k1", "", "", "k9", "k7"]
    rng = np.random.default_rng(0)
    poses = [made_poses(rng) for _ in clips]
    poses[3] = poses[1] + 1e-3 * rng.normal(size=poses[1].shape)
    group = same_motion_groups(clips, keys, [as_signature(one) for one in poses])
    np.testing.assert_array_equal(group, [0, 1, 0, 1, 2, 0, 3])
    np.testing.assert_array_equal(same_motion_groups(clips), [0, 1, 2, 3, 4, 0, 5])


@pytest.mark.later
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 20), start=st.integers(0, 30), length=st.integers(25, 50), flip=st.booleans())
def test_a_piece_is_found_in_its_whole_and_other_motions_are_not(seed, start, length, flip):
    rng = np.random.default_rng(seed)
    poses = [made_poses(rng) for _ in range(12)]
    pieces = [one[start : start + length] + 0.004 * rng.normal(size=(length, WIDTH)) for one in poses[:5]]
    pieces = [mirrored_poses(piece) for piece in pieces] if flip else pieces
    group = groups_of([*poses, *pieces])
    np.testing.assert_array_equal(group[12:], group[:5])
    assert len(np.unique(group)) == 12


def test_pieces_that_do_not_overlap_are_one_by_their_whole():
    poses = made_poses(np.random.default_rng(1))
    other = made_poses(np.random.default_rng(2))
    assert groups_of([poses[:40], poses[40:], other]).tolist() == [0, 1, 2]
    assert groups_of([poses[:40], poses[40:], other, poses]).tolist() == [0, 0, 1, 0]
    in_a_row = np.concatenate([other, poses])
    assert groups_of([poses, other, in_a_row]).tolist() == [0, 0, 0]


def test_who_stands_still_shares_nothing():
    rng = np.random.default_rng(3)
    moves = [made_poses(rng, 40) for _ in range(2)]
    still = np.repeat(moves[0][-1:], 60, axis=0)
    stood = [np.concatenate([still + 0.002 * rng.normal(size=still.shape), one]) for one in moves]
    stood[1][60:] += moves[0][-1] - moves[1][0]
    assert groups_of(stood).tolist() == [0, 1]


def test_whoever_holds_a_pose_is_a_copy_of_who_holds_the_same_alone():
    rng = np.random.default_rng(4)
    held = made_poses(rng, 1)
    breathing = 0.01 * np.sin(np.arange(120) / 6)[:, None] * rng.normal(size=WIDTH)

    def noisy(poses):
        return poses + 0.006 * rng.normal(size=poses.shape)

    copies = [held + breathing, noisy(held + breathing[:70]), noisy(mirrored_poses(held + breathing[40:]))]
    another = held + breathing + 0.03 * rng.normal(size=WIDTH)
    assert groups_of([*copies, another, noisy(another[20:])]).tolist() == [0, 0, 0, 1, 1]


def test_a_clip_alone_and_clips_all_alike():
    poses = made_poses(np.random.default_rng(0))
    assert groups_of([poses]).tolist() == [0]
    assert groups_of([poses] * 3).tolist() == [0, 0, 0]
    short = [poses[:1], poses[:3], poses[5:9]]
    assert groups_of(short).tolist() == [0, 1, 2]


@pytest.mark.later
def test_the_search_in_blocks_finds_what_one_block_finds(monkeypatch):
    rng = np.random.default_rng(2)
    poses = [made_poses(rng) for _ in range(30)]
    poses += [mirrored_poses(one[10:60]) for one in poses[:10]]
    whole = groups_of(poses)
    monkeypatch.setattr(signature, "ROWS_AT_ONCE", 3)
    monkeypatch.setattr(shared_stretches, "PAIRS_AT_ONCE", 5)
    monkeypatch.setattr(shared_stretches, "IN_FULL_AT_ONCE", 2)
    monkeypatch.setattr(shared_stretches, "CLIPS_AT_ONCE", 7)
    np.testing.assert_array_equal(groups_of(poses), whole)
    assert len(np.unique(whole)) == 30


@pytest.mark.slow
def test_the_search_holds_no_second_copy_of_the_signatures(monkeypatch):
    monkeypatch.setattr(shared_stretches, "PAIRS_AT_ONCE", 100)
    monkeypatch.setattr(shared_stretches, "CLIPS_AT_ONCE", 50)
    monkeypatch.setattr(shared_stretches, "FOR_AXES", 50)
    rng = np.random.default_rng(0)
    signatures = [as_signature(made_poses(rng)) for _ in range(2000)]
    tracemalloc.start()
    found = same_motion_groups([str(n) for n in range(2000)], signatures=signatures)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(np.unique(found)) == 2000
    assert peak < sum(one.nbytes for one in signatures)


def test_signatures_of_an_earlier_version_are_refused():
    with pytest.raises(ValueError, match="an earlier version of W2W made the signals"):
        same_motion_groups(["a", "b"], None, [np.zeros(1441, np.float32)] * 2)
