# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips of one and the same motion are found by name, key or likeness, and others are not."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.sparse.csgraph import connected_components

from w2w.core.ranking import same_motion
from w2w.core.ranking.same_motion import same_motion_groups


def test_one_motion_is_one_group_by_name_key_or_likeness_and_by_chain():
    clips = ["a", "b", "c", "d", "e", "a", "f"]
    keys = ["k1", "k2", "k1", "", "", "k9", "k7"]
    rng = np.random.default_rng(0)
    signatures = rng.normal(size=(7, 20))
    signatures[3] = signatures[1] + 1e-3
    group = same_motion_groups(clips, keys, signatures)
    np.testing.assert_array_equal(group, [0, 1, 0, 1, 2, 0, 3])
    np.testing.assert_array_equal(same_motion_groups(clips), [0, 1, 2, 3, 4, 0, 5])


@given(noise=st.floats(0, 0.03), seed=st.integers(0, 20))
def test_nearly_equal_motions_are_found_and_others_are_not(noise, seed):
    rng = np.random.default_rng(seed)
    signatures = rng.normal(size=(30, 40)) * rng.uniform(0.1, 10, 40)
    copy = signatures[:5] + noise * signatures.std(axis=0) * rng.uniform(-1, 1, (5, 40))
    group = same_motion_groups([str(k) for k in range(35)], signatures=np.concatenate([signatures, copy]))
    np.testing.assert_array_equal(group[30:], group[:5])
    assert len(np.unique(group)) == 30


def test_a_clip_alone_and_clips_all_alike():
    assert same_motion_groups(["a"], signatures=np.ones((1, 3))).tolist() == [0]
    assert same_motion_groups(["a", "b", "c"], signatures=np.ones((3, 3))).tolist() == [0, 0, 0]


def test_the_search_on_few_axes_finds_what_every_pair_tells():
    rng = np.random.default_rng(3)
    kinds = rng.normal(size=(12, 60)) * np.geomspace(3, 0.1, 60)
    signatures = kinds[rng.integers(12, size=80)] + rng.uniform(0, 0.06, (80, 1)) * rng.normal(size=(80, 60))
    signatures[40:52] = signatures[:12, ::-1] + 0.01
    mirrored = signatures[:, ::-1]
    unit = (signatures - signatures.mean(axis=0)) / signatures.std(axis=0)
    other = (mirrored - signatures.mean(axis=0)) / signatures.std(axis=0)
    near = np.eye(80, dtype=bool)
    for one in (unit, other):
        near |= np.linalg.norm(one[:, None] - unit, axis=2) <= 0.1 * np.sqrt(60)
    expected = connected_components(near | near.T, directed=False)[1]
    found = same_motion_groups(
        [str(k) for k in range(80)],
        signatures=list(signatures),
        tolerance=0.1,
        mirrored=lambda rows: rows[:, ::-1],
    )
    assert 12 < len(set(found.tolist())) < 80
    assert len(set(zip(found.tolist(), expected.tolist(), strict=True))) == len(set(expected.tolist()))
    assert len(set(found.tolist())) == len(set(expected.tolist()))


@pytest.mark.parametrize(("distance", "groups"), [(0.9, 1), (1.1, 2)])
def test_motions_are_one_up_to_the_tolerance(distance, groups):
    """Root mean square over the columns, in each one's standard deviations; 0.05 by default."""
    rng = np.random.default_rng(0)
    others = rng.normal(size=(400, 30)) * rng.uniform(0.1, 10, 30)
    deviation = np.concatenate([others, others[:1]]).std(axis=0)
    step = rng.choice([-1, 1], 30) * np.linspace(0.5, 1.5, 30)
    step *= distance * 0.05 / np.sqrt((step**2).mean())
    signatures = np.concatenate([others, others[:1] + step * deviation])
    group = same_motion_groups([str(i) for i in range(401)], signatures=signatures)
    assert len(np.unique(group)) == 399 + groups
    assert bool(group[400] == group[0]) is (groups == 1)


def test_however_signatures_are_held_the_same_are_found():
    rng = np.random.default_rng(1)
    signatures = rng.normal(size=(300, 50)) * np.geomspace(5, 0.05, 50)
    signatures[200:] = signatures[:100] + 0.02 * signatures.std(axis=0)
    clips = [str(k) for k in range(300)]
    found = same_motion_groups(clips, signatures=signatures)
    np.testing.assert_array_equal(found[200:], found[:100])
    np.testing.assert_array_equal(same_motion_groups(clips, signatures=signatures.astype(np.float32)), found)


def test_the_search_in_blocks_finds_what_one_block_finds(monkeypatch):
    rng = np.random.default_rng(2)
    signatures = rng.normal(size=(40, 30))[rng.integers(40, size=120)] + 0.02 * rng.normal(size=(120, 30))
    signatures[100:] = -signatures[:20] + 0.02
    clips = [str(k) for k in range(120)]
    whole = same_motion_groups(clips, signatures=signatures, mirrored=np.negative)
    monkeypatch.setattr(same_motion, "PRODUCTS", 1)
    monkeypatch.setattr(same_motion, "ROWS_AT_ONCE", 13)
    monkeypatch.setattr(same_motion, "PAIRS_AT_ONCE", 7)
    monkeypatch.setattr(same_motion, "FOR_AXES", 11)
    found = same_motion_groups(clips, signatures=signatures, mirrored=np.negative)
    np.testing.assert_array_equal(found, whole)
    assert 1 < len(np.unique(whole)) < 40


@pytest.mark.slow
def test_the_search_holds_no_second_copy_of_the_signatures(monkeypatch):
    monkeypatch.setattr(same_motion, "PRODUCTS", 100_000)
    monkeypatch.setattr(same_motion, "ROWS_AT_ONCE", 100)
    monkeypatch.setattr(same_motion, "FOR_AXES", 100)
    signatures = np.random.default_rng(0).normal(size=(5000, 400)).astype(np.float32)
    tracemalloc.start()
    found = same_motion_groups([str(k) for k in range(5000)], signatures=signatures, mirrored=np.negative)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(np.unique(found)) == 5000
    assert peak < signatures.nbytes + 5000 * same_motion.AXES * 8
