# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies that stand, lie, hang and travel in every way that an axis may be guessed from, with the truth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS, PARENTS, Body
from w2w.core.motion.motion import Motion

RATE = 30.0
SECONDS = 4.0
SIDES = (("left", 1.0), ("right", -1.0))
TIME = np.arange(round(RATE * SECONDS)) / RATE

Turns = dict[str, np.ndarray]
Built = tuple[Turns, np.ndarray, np.ndarray]
"""Turns of joints (rotation vectors, degrees), of the whole body, and the path of its pelvis."""


def _sines(pace: float, lag: float = 0.0) -> np.ndarray:
    return np.sin(2 * np.pi * (pace * TIME + lag))


def _about(
    x: float | np.ndarray = 0.0, y: float | np.ndarray = 0.0, z: float | np.ndarray = 0.0
) -> np.ndarray:
    return np.stack([axis + 0 * TIME for axis in (x, y, z)], axis=1)


def _legs(hip: float | np.ndarray, knee: float | np.ndarray, swing: float = 0.0, pace: float = 1.0) -> Turns:
    """Hips and knees bent by degrees; with a swing they alternate."""
    turns = {}
    for number, (side, _) in enumerate(SIDES):
        beat = swing * _sines(pace, number / 2)
        turns[f"{side}_hip"] = _about(-(hip + beat))
        turns[f"{side}_knee"] = _about(knee + np.abs(beat))
    return turns


def _arms(down: float = 0.0, forward: float = 0.0, elbow: float | np.ndarray = 0.0) -> Turns:
    turns = {}
    for side, sign in SIDES:
        turns[f"{side}_shoulder"] = _about(y=sign * down, z=-sign * forward)
        turns[f"{side}_elbow"] = _about(z=-sign * elbow)
    return turns


STILL = np.zeros((len(TIME), 3))
PRONE, SUPINE = _about(x=90.0), _about(x=-90.0)
HANGING, CLOSE = _arms(down=70.0), _arms(down=88.0)


def _along(speed: float, axis: int = 1, sign: float = -1.0) -> np.ndarray:
    path = STILL.copy()
    path[:, axis] = sign * speed * TIME
    return path


def stand() -> Built:
    return {**HANGING, "head": _about(z=20 * _sines(0.3))}, _about(x=1.5 * _sines(0.4)), STILL


def wave() -> Built:
    turns = {
        **HANGING,
        "right_shoulder": _about(y=60 + 20 * _sines(1.5)),
        "spine2": _about(z=5 * _sines(0.7)),
    }
    return turns, STILL, STILL


def walk() -> Built:
    return {**HANGING, **_legs(0, 5, 25)}, _about(x=3.0), _along(1.2)


def side_steps() -> Built:
    return {**HANGING, **_legs(10, 20, 8)}, STILL, _along(0.7, axis=0)


def stairs() -> Built:
    path = _along(0.55)
    path[:, 2] = 0.34 * TIME
    return {**HANGING, **_legs(35, 45, 30)}, _about(x=8.0), path


def squat() -> Built:
    depth = 45 * (1 - np.cos(2 * np.pi * 0.5 * TIME))
    return {**_arms(forward=90.0), **_legs(depth, 1.2 * depth)}, _about(x=0.35 * depth), STILL


def chair() -> Built:
    return {**_arms(down=60.0, elbow=70.0), **_legs(88, 85)}, _about(x=4 * _sines(0.4)), STILL


def wheelchair() -> Built:
    push = _arms(down=60.0, elbow=60 + 25 * _sines(0.8))
    return {**push, **_legs(85, 75)}, _about(x=4 + 6 * _sines(0.8)), STILL


def wheelchair_far() -> Built:
    turns, whole, _ = wheelchair()
    return turns, whole, _along(1.1)


def turn_on_the_spot() -> Built:
    return {**HANGING, **_legs(5, 10, 6)}, _about(z=90 * TIME), STILL


def one_leg() -> Built:
    turns = {**HANGING, **_legs(0, 0)}
    return turns | {"right_hip": _about(-60 + 8 * _sines(0.5)), "right_knee": _about(80.0)}, STILL, STILL


def plank() -> Built:
    return {**_arms(forward=90.0), "spine2": _about(2 * _sines(0.5))}, _about(x=76.0), STILL


def push_up() -> Built:
    deep = 0.5 * (1 - np.cos(2 * np.pi * 0.6 * TIME))
    return _arms(forward=90.0, elbow=80 * deep), _about(x=75 + 11 * deep), STILL


def crawl() -> Built:
    arms = {
        f"{side}_shoulder": _about(z=-sign * (90 + 15 * _sines(0.8, 0.5 * (sign > 0))))
        for side, sign in SIDES
    }
    return {**arms, **_legs(90, 90, 12, 0.8)}, _about(x=85.0), _along(0.35)


def crawl_in_place() -> Built:
    turns, whole, _ = crawl()
    return turns, whole, STILL


def sit_up() -> Built:
    rise = 0.5 * (1 - np.cos(2 * np.pi * 0.4 * TIME))
    turns = {**_arms(forward=60.0, elbow=40.0), **_legs(50 + 55 * rise, 80)}
    return turns, _about(x=-90 + 55 * rise), STILL


def supine() -> Built:
    return {**HANGING, "head": _about(z=15 * _sines(0.3))}, SUPINE, STILL


def knees_up() -> Built:
    return {**HANGING, **_legs(45, 60)}, SUPINE + _about(x=3 * _sines(0.3)), STILL


def prone() -> Built:
    return {**HANGING, "head": _about(z=60.0)}, PRONE, STILL


def side_lying() -> Built:
    return {**CLOSE, **_legs(25, 40, 3, 0.3)}, _about(y=-90.0), STILL


def swim() -> Built:
    strokes = {f"{side}_shoulder": _about(x=sign * 360 * 0.7 * TIME, y=-80 * sign) for side, sign in SIDES}
    return {**strokes, **_legs(0, 10, 15, 2.0)}, _about(x=88.0, z=3 * _sines(0.7)), _along(1.4)


def swim_far() -> Built:
    turns, whole, _ = swim()
    return turns, whole, _along(5.0)


def handstand() -> Built:
    return {**_arms(down=-85.0), **_legs(0, 0, 4, 0.6)}, _about(x=180 + 3 * _sines(0.5)), STILL


def handwalk() -> Built:
    turns, whole, _ = handstand()
    return turns, whole, _along(0.5)


def roll_over() -> Built:
    """From the back by the side to the front, and back."""
    turned = 90 * (1 - np.cos(2 * np.pi * TIME / SECONDS))
    laid = Rotation.from_rotvec(SUPINE, degrees=True) * Rotation.from_rotvec(_about(z=turned), degrees=True)
    path = STILL.copy()
    path[:, 0] = turned / 180 * 0.5
    return CLOSE, np.degrees(laid.as_rotvec()), path


def log_roll() -> Built:
    laid = Rotation.from_rotvec(SUPINE, degrees=True) * Rotation.from_rotvec(
        _about(z=180 * TIME), degrees=True
    )
    return CLOSE, np.degrees(laid.as_rotvec()), _along(0.45, axis=0)


def get_up() -> Built:
    """Lies for a while and stands up."""
    rise = np.clip((TIME - 1.5) / 1.0, 0, 1)
    return (
        {**HANGING, **_legs(40 * np.sin(np.pi * rise), 60 * np.sin(np.pi * rise))},
        _about(x=-90 + 90 * rise),
        STILL,
    )


TEN: dict[str, Callable[[], Built]] = {
    kind.__name__: kind
    for kind in (plank, push_up, crawl, sit_up, supine, side_lying, swim, handstand, wheelchair, stand)
}
"""The ten kinds."""

MORE: dict[str, Callable[[], Built]] = {
    kind.__name__: kind
    for kind in (
        wave, walk, side_steps, stairs, squat, chair, wheelchair_far, turn_on_the_spot, one_leg,
        crawl_in_place, knees_up, prone, swim_far, handwalk, roll_over, log_roll, get_up,
    )
}  # fmt: skip

UPRIGHT = ("stand", "wave", "walk", "side_steps", "stairs", "squat", "turn_on_the_spot", "one_leg")
"""Kinds that stand on their feet."""

JOINT_RADIUS = 0.05
"""Metres from the lowest joint to the ground."""


def joints_of(body: Body, rotations: np.ndarray, pelvis: np.ndarray) -> np.ndarray:
    """Places (T, 24, 3) of the joints, worked out one by one."""
    turns = [rotations[:, 0]]
    places = [pelvis]
    for joint in range(1, N_JOINTS):
        parent = PARENTS[joint]
        bone = body.joints[joint] - body.joints[parent]
        places.append(places[parent] + np.einsum("tab,b->ta", turns[parent], bone))
        turns.append(np.einsum("tab,tbc->tac", turns[parent], rotations[:, joint]))
    return np.stack(places, axis=1)


def trunk_of(places: np.ndarray) -> np.ndarray:
    """Medians over frames (2, 3) of two unit vectors in places (T, 24, 3) of the joints.

    They lead from between the hips to between the shoulders, and from the right hip to the left one.
    """
    at = {
        name: places[:, JOINT_INDEX[name]]
        for name in ("left_hip", "right_hip", "left_shoulder", "right_shoulder")
    }
    trunk = at["left_shoulder"] + at["right_shoulder"] - at["left_hip"] - at["right_hip"]
    lines = np.stack([trunk, at["left_hip"] - at["right_hip"]])
    return np.median(lines / np.linalg.norm(lines, axis=2, keepdims=True), axis=1)


def posed(
    kind: str, body: Body, heading: float = 0.0, floor: float | None = 0.0, start: str = "hips", seed: int = 0
) -> Motion:
    """A kind of motion, z up, turned by a heading (degrees) on a floor at a height (m).

    It starts with the hips or the feet above the origin or at another place ("away"); without a floor the
    hips stay at the origin.
    """
    turns, whole, path = {**TEN, **MORE}[kind]()
    rotations = np.tile(np.eye(3), (len(TIME), N_JOINTS, 1, 1))
    jitter = np.random.default_rng(seed).normal(0, 0.4, (N_JOINTS, 3))
    for joint in range(1, N_JOINTS):  # nobody holds a joint wholly still
        rotations[:, joint] = Rotation.from_rotvec(
            _sines(0.25, joint / 7)[:, None] * jitter[joint], degrees=True
        ).as_matrix()
    for name, turn in turns.items():
        rotations[:, JOINT_INDEX[name]] = Rotation.from_rotvec(turn, degrees=True).as_matrix()
    facing = Rotation.from_euler("z", heading, degrees=True).as_matrix()
    rotations[:, 0] = facing @ Rotation.from_rotvec(whole, degrees=True).as_matrix()
    if floor is None:
        return Motion(rotations, STILL, RATE)
    pelvis = path @ facing.T
    places = joints_of(body, rotations, pelvis)
    lowest = places[..., 2].min(axis=1)
    pelvis[:, 2] += floor + JOINT_RADIUS + path[:, 2] - (lowest.min() if kind.startswith("swim") else lowest)
    feet = places[0, [JOINT_INDEX["left_ankle"], JOINT_INDEX["right_ankle"]]].mean(axis=0)
    pelvis[:, :2] -= {"hips": pelvis[0, :2], "feet": feet[:2], "away": np.array([2.3, -1.7]) @ np.eye(2)}[
        start
    ]
    return Motion(rotations, pelvis, RATE)
