# SPDX-License-Identifier: GPL-3.0-or-later
"""Skeletons whose names say nothing are matched by chains, symmetry and positions, and others refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, JOINT_NAMES, N_JOINTS, PARENTS
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import SourceMotion, UnusableMotion
from w2w.core.readers.bvh import read_bvh
from w2w.core.retargeting.retarget import matched_joints
from w2w.core.retargeting.structure_match import match_by_structure

from ...rings import by_day
from .unnamed_rigs import unnamed_rig


def nameless(body, seed, scale=1.0, names="bone", swing=0.5):
    """The body's skeleton with fingers, end sites, twist bones and doubled hips, in a scrambled order.

    Returns the source, and for each of the 24 joints the bone that is the joint.
    """
    generator = np.random.default_rng(seed)
    heads = [*body.joints]
    parents = [*PARENTS]
    labels = [*JOINT_NAMES]

    def add(label, parent, offset):
        heads.append(heads[parent] + np.array(offset))
        parents.append(parent)
        labels.append(label)
        return len(heads) - 1

    for side, sign in (("left", 1), ("right", -1)):
        wrist, hand = JOINT_INDEX[f"{side}_wrist"], JOINT_INDEX[f"{side}_hand"]
        for finger, y in (("thumb", -0.04), ("index", -0.02), ("ring", 0.02), ("little", 0.04)):
            first = add(f"{side} {finger} 1", wrist, body.joints[hand] - body.joints[wrist] + (0, y, 0))
            add(f"{side} {finger} 2", first, (sign * 0.03, 0, 0))
        add(f"{side} fingertip", hand, (sign * 0.05, 0, 0))
        add(f"{side} toe tip", JOINT_INDEX[f"{side}_foot"], (0, -0.06, 0))
        add(f"{side} upper arm twist", JOINT_INDEX[f"{side}_shoulder"], (sign * 0.12, 0, 0))
        add(f"{side} eye", JOINT_INDEX["head"], (sign * 0.03, -0.08, 0.06))
    add("crown", JOINT_INDEX["head"], (0, 0, 0.2))
    rotations = np.tile(np.eye(3), (12, len(heads), 1, 1))
    turns = Rotation.from_rotvec(swing * generator.normal(size=(12 * N_JOINTS, 3)) / 2).as_matrix()
    rotations[:, :N_JOINTS] = turns.reshape(12, N_JOINTS, 3, 3)
    for side, sign in (("left", 1), ("right", -1)):  # knees and elbows bend as people's do
        bend = generator.uniform(0.1, 1.2, (2, 12))
        knee = Rotation.from_rotvec(bend[0][:, None] * [1, 0, 0]).as_matrix()
        rotations[:, JOINT_INDEX[f"{side}_knee"]] = knee
        elbow = Rotation.from_rotvec(bend[1][:, None] * [0, 0, -sign]).as_matrix()
        rotations[:, JOINT_INDEX[f"{side}_elbow"]] = elbow
    world = np.zeros((12, len(heads), 4, 4))
    world[..., 3, 3] = 1
    for bone, parent in enumerate(parents):
        if parent < 0:
            world[:, bone, :3, :3], world[:, bone, :3, 3] = rotations[:, bone], heads[bone]
            continue
        world[:, bone, :3, :3] = world[:, parent, :3, :3] @ rotations[:, bone]
        offset = world[:, parent, :3, :3] @ (heads[bone] - heads[parent])
        world[:, bone, :3, 3] = world[:, parent, :3, 3] + offset
    world[..., :3, 3] *= scale
    order = scrambled(parents, generator)
    place = np.argsort(order)
    source = SourceMotion(
        bones=tuple(f"{names}{i}" if names else labels[i] for i in order),
        parents=np.array([-1 if parents[i] < 0 else place[parents[i]] for i in order]),
        rest=world[0, order],  # any frame: what plays what must not hang on the rest pose
        matrices=world[:, order],
        rate=30.0,
    )
    return source, {joint: int(place[joint]) for joint in range(N_JOINTS)}


def scrambled(parents, generator):
    """The bones in a random order that keeps parents before children."""
    order, ready = [], [i for i, parent in enumerate(parents) if parent < 0]
    while ready:
        bone = ready.pop(generator.integers(len(ready)))
        order.append(bone)
        ready += [child for child, parent in enumerate(parents) if parent == bone]
    return np.array(order)


@pytest.mark.later
@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([1.0, 0.01, 37.0]))
def test_every_joint_is_found_left_from_right(bundled_body, seed, scale):
    source, truth = nameless(bundled_body, seed, scale)
    assert match_by_structure(source) == truth


SEGMENTS = [
    (JOINT_INDEX[f"{side}_{start}"], JOINT_INDEX[f"{side}_{end}"])
    for side in ("left", "right")
    for start, end in (("shoulder", "elbow"), ("elbow", "wrist"), ("hip", "knee"), ("knee", "ankle"))
]


def limbs_apart(source, matched, truth):
    """Largest angle between limbs by two matches, degrees."""
    ways = []
    for bones in (matched, truth):
        starts, ends = np.vectorize(bones.get)(np.transpose(SEGMENTS))
        way = source.matrices[:, ends, :3, 3] - source.matrices[:, starts, :3, 3]
        ways.append(way / np.linalg.norm(way, axis=-1, keepdims=True))
    return np.degrees(np.arccos(np.clip((ways[0] * ways[1]).sum(axis=-1), -1, 1)).max())


@pytest.mark.parametrize("seeds", by_day([range(80)], [range(80), range(80, 800)]))
def test_bones_without_names_are_matched_rightly_or_refused(bundled_body, seeds):
    """Long, short, doubled and no collars; bones for the twist, in line or hanging; fingers or none."""
    found = [(*unnamed_rig(bundled_body, seed), seed) for seed in seeds]
    apart = {
        seed: limbs_apart(source, matched, truth)
        for source, truth, seed in found
        if (matched := match_by_structure(source))
    }
    assert not {seed: angle for seed, angle in apart.items() if angle > 0.1}
    assert len(apart) > 0.6 * len(found)


def test_a_long_collar_is_no_upper_arm(shared_cases):
    """By its names it is told; without them it is unclear which bone the upper arm is."""
    source = read_bvh(shared_cases / "second/hyphen_prefix_long_collar.bvh")
    name, matched = matched_joints(source)
    assert name == "Rigify (first)"
    assert source.bones[matched[JOINT_INDEX["left_shoulder"]]] == "B-upperArm.L"
    assert match_by_structure(replace(source, bones=tuple(f"b{n}" for n in range(len(source.bones))))) == {}


def test_sides_in_names_are_believed(bundled_body):
    """With toes cut off and straight legs, only the names can tell."""
    source, truth = nameless(bundled_body, 4, names="", swing=0.0)
    matched = match_by_structure(source)
    assert {joint: matched[joint] for joint in (16, 17, 1, 2)} == {
        joint: truth[joint] for joint in (16, 17, 1, 2)
    }


@pytest.mark.parametrize(
    ("name", "side"),
    [
        ("L_Thigh", "left"), ("thigh.R", "right"), ("LeftFoot", "left"), ("Bip01 R Calf", "right"),
        ("upperleg_l", "left"), ("calf", ""), ("roll", ""), ("mixamorig:RightArm", "right"),
        ("lThigh", "left"), ("RUArm", "right"), ("L5", ""), ("Spine_L3", ""),
    ],
)  # fmt: skip
def test_sides_are_read_from_names(name, side):
    from w2w.core.retargeting.structure_match import _named_side

    assert _named_side(name) == side


def chain(lengths, start=(0, 0, 0), step=(0, 0, 1)):
    return np.array(start) + np.cumsum([0, *lengths])[:, None] * np.array(step)


def rig(parents, heads):
    matrices = np.tile(np.eye(4), (6, len(parents), 1, 1))
    matrices[..., :3, 3] = heads
    bones = tuple(f"b{i}" for i in range(len(parents)))
    return SourceMotion(bones, np.array(parents), matrices[0], matrices, 30.0)


def test_things_that_are_no_people_are_not_matched(bundled_body):
    snake = rig(list(range(-1, 29)), chain(np.full(29, 0.1)))
    assert match_by_structure(snake) == {}
    star = rig([-1] + 23 * [0], bundled_body.joints)
    assert match_by_structure(star) == {}
    hand_parents, heads = [-1], [np.zeros(3)]
    for finger in range(5):
        parent = 0
        for bone in range(4):
            hand_parents.append(parent)
            parent = len(heads)
            heads.append(np.array([0.02 * finger, 0.08 + 0.03 * bone, 0]))
    assert match_by_structure(rig(hand_parents, heads)) == {}
    table_parents, heads = [-1], [np.zeros(3)]
    for x in (-1, 1):
        for y in (-1, 1):
            table_parents += [0, len(heads), len(heads) + 1]
            heads += [np.array([x, y, z]) for z in (0, -0.4, -0.8)]
    assert match_by_structure(rig(table_parents, heads)) == {}


def test_a_body_without_arms_is_not_matched(bundled_body):
    source, truth = nameless(bundled_body, 1)
    below = [truth[JOINT_INDEX[f"{side}_collar"]] for side in ("left", "right")]
    gone = np.zeros(len(source.bones), dtype=bool)
    for bone, parent in enumerate(source.parents):
        gone[bone] = bone in below or (parent >= 0 and gone[parent])
    kept = np.flatnonzero(~gone)
    place = np.cumsum(~gone) - 1
    parents = np.array([-1 if source.parents[i] < 0 else place[source.parents[i]] for i in kept])
    bones = tuple(source.bones[i] for i in kept)
    armless = replace(
        source, bones=bones, parents=parents, rest=source.rest[kept], matrices=source.matrices[:, kept]
    )
    assert match_by_structure(armless) == {}


def test_still_motion_needs_no_bend(bundled_body):
    """Straight limbs in a T-pose: toes alone tell the front."""
    positions = joint_transforms(
        bundled_body, Motion(np.tile(np.eye(3), (5, N_JOINTS, 1, 1)), np.zeros((5, 3)), 30)
    )[1]
    matched = match_by_structure(rig(list(PARENTS), positions[0]))
    assert matched == {joint: joint for joint in range(N_JOINTS)}


@pytest.mark.later
def test_thousands_of_bones_in_a_row_are_looked_at(bundled_body):
    """A tail on its own is nobody; a person with a long plait is one."""
    tail = rig(list(range(-1, 1999)), chain(np.full(1999, 0.01)))
    with pytest.raises(UnusableMotion, match="by name or by structure"):
        matched_joints(tail)
    head = JOINT_INDEX["head"]
    plait = chain(np.full(1999, 1e-4), bundled_body.joints[head], (0, 1, 0))
    parents = [*PARENTS, head, *range(N_JOINTS, N_JOINTS + len(plait) - 1)]
    matched = match_by_structure(rig(parents, np.concatenate([bundled_body.joints, plait])))
    assert matched == {joint: joint for joint in range(N_JOINTS)}
