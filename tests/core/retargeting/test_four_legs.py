# SPDX-License-Identifier: GPL-3.0-or-later
"""Animals with a person's names are refused, people on hands and feet or knees are not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, JOINT_NAMES, PARENTS
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import SourceMotion, UnusableMotion
from w2w.core.readers.bvh import read_bvh
from w2w.core.retargeting.retarget import retarget

FRAMES = 60


def on_the_body(body, turns):
    """A motion (T, 24, 3, 3) of the body, on a skeleton of SMPL's names whose rest pose is the body's."""
    motion = Motion(turns, np.tile([0, 0, 1.0], (len(turns), 1)), 30.0)
    matrices, rest = np.tile(np.eye(4), (len(turns), 24, 1, 1)), np.tile(np.eye(4), (24, 1, 1))
    matrices[..., :3, :3], matrices[..., :3, 3] = joint_transforms(body, motion)
    rest[:, :3, 3] = body.joints
    return SourceMotion(JOINT_NAMES, np.array(PARENTS), rest, matrices, 30.0)


def on_hands(body, knees):
    """A person on hands and feet whose trunk lies level, the knees bent by so many degrees."""
    swing = 15 * np.sin(np.arange(FRAMES) / 5)
    turns = np.tile(np.eye(3), (FRAMES, 24, 1, 1))
    turns[:, 0] = Rotation.from_euler("x", 90, degrees=True).as_matrix()
    for side, sign in (("left", 1), ("right", -1)):
        arms = Rotation.from_euler("y", sign * 85, degrees=True), Rotation.from_euler("x", -90, degrees=True)
        forth = Rotation.from_euler("x", sign * swing, degrees=True)
        turns[:, JOINT_INDEX[f"{side}_shoulder"]] = (forth * arms[1] * arms[0]).as_matrix()
        hip = Rotation.from_euler("x", -90 - (knees / 2 if knees < 60 else 0) - sign * swing, degrees=True)
        turns[:, JOINT_INDEX[f"{side}_hip"]] = hip.as_matrix()
        turns[:, JOINT_INDEX[f"{side}_knee"]] = Rotation.from_euler("x", knees, degrees=True).as_matrix()
    return on_the_body(body, turns)


def animal(arms, back, known, sits=False, seed=0):
    """A four-legged walk: length of arms to legs, of the back to legs, and whether its rest pose is known."""
    rng = np.random.default_rng(seed)
    names = [name for name in JOINT_NAMES if "hand" not in name]
    heads = {"pelvis": np.array([0, 0, 1.0])}
    for part in ("spine1", "spine2", "spine3", "neck", "head"):
        heads[part] = [*heads.values()][-1] + np.array([0, -back / 3, 0.02])
    for side, sign in (("left", 1), ("right", -1)):
        heads[f"{side}_collar"] = heads["spine3"] + [sign * 0.05, 0, 0]
        for first, size, parts in (
            (heads["spine3"], arms, ("shoulder", "elbow", "wrist")),
            (heads["pelvis"], 1.0, ("hip", "knee", "ankle", "foot")),
        ):
            ways = size * np.array([[0, 0.1, -0.45], [0, -0.1, -0.45], [0, -0.15, -0.05]])
            places = first + [sign * 0.12, 0, -0.05] + np.cumsum([np.zeros(3), *ways], axis=0)
            heads |= {f"{side}_{part}": place for part, place in zip(parts, places, strict=False)}
    parents = [
        -1 if name == "pelvis" else names.index(JOINT_NAMES[PARENTS[JOINT_INDEX[name]]]) for name in names
    ]
    phase = np.arange(FRAMES) / 6
    matrices = np.tile(np.eye(4), (FRAMES, len(names), 1, 1))
    for bone, (name, parent) in enumerate(zip(names, parents, strict=True)):
        diagonal = name.startswith("left") == name.endswith(("shoulder", "elbow", "wrist"))
        gait = (
            25 * np.sin(phase + np.pi * diagonal) if name.endswith(("hip", "shoulder")) else 2 * np.sin(phase)
        )
        if sits and name.endswith("hip"):
            gait = gait - 70
        base = matrices[:, parent] if parent >= 0 else np.eye(4)
        turn = Rotation.from_euler("x", gait, degrees=True).as_matrix()
        shift = heads[name] - (heads[names[parent]] if parent >= 0 else 0)
        matrices[:, bone, :3, :3] = base[..., :3, :3] @ turn
        matrices[:, bone, :3, 3] = base[..., :3, 3] + base[..., :3, :3] @ shift
    rest = np.tile(np.eye(4), (len(names), 1, 1))
    rest[:, :3, 3] = [heads[name] for name in names]
    facing = np.eye(4)
    facing[:3, :3] = Rotation.from_euler("z", rng.uniform(0, 360), degrees=True).as_matrix()
    rest = rest if known else matrices[0]
    return SourceMotion(tuple(names), np.array(parents), rest, facing @ matrices, 30.0, rest_is_known=known)


@pytest.mark.parametrize("arms", [0.85, 0.95, 1.1])
@pytest.mark.parametrize("back", [0.7, 1.3])
@pytest.mark.parametrize("known", [True, False])
def test_an_animal_with_a_persons_names_is_refused(bundled_body, arms, back, known):
    with pytest.raises(UnusableMotion, match="an animal with four legs"):
        retarget(animal(arms, back, known), bundled_body)


def test_an_animal_is_known_by_its_rest_pose_whatever_it_does(bundled_body):
    with pytest.raises(UnusableMotion, match="rests on all fours and its arms are as long as its legs"):
        retarget(animal(0.95, 1.0, known=True, sits=True), bundled_body)


def test_the_beast_of_a_bvh_file_is_known_by_its_offsets(shared_cases):
    with pytest.raises(UnusableMotion, match="rests on all fours"):
        read_bvh(shared_cases / "second/four_legs_biped_names.bvh")


@pytest.mark.parametrize("knees", [0, 40, 90])
@pytest.mark.parametrize("known", [True, False])
def test_people_on_hands_and_feet_or_knees_are_read(bundled_body, knees, known):
    source = replace(on_hands(bundled_body, knees), rest_is_known=known)
    trunk = source.matrices[0, JOINT_INDEX["spine3"], :3, 3] - source.matrices[0, 0, :3, 3]
    assert abs(trunk[2]) < 0.3 * np.linalg.norm(trunk)
    assert retarget(source, bundled_body).motion.n_frames == FRAMES
