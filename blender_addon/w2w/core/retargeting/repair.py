# SPDX-License-Identifier: GPL-3.0-or-later
"""Correct BVH files: drop T-poses at the ends, find the axis that is up and a rest pose that people can take.

A BVH file has no rest pose: its offsets are one only where the exporter's bones were not turned. Many
start with a T-pose that is no part of the motion, and some are z-up though the format is y-up.
"""

from collections.abc import Sequence
from dataclasses import replace
from zlib import crc32

import numpy as np

from ..body.body import BODY_HANDS, JOINT_INDEX, trunk_line
from ..motion.believable import REST_POSE, cut_words, moving_part, shows_rest
from ..motion.sight import SEEN_FRAMES, UPS, Kind, Sight, Up, stood
from ..motion.source import TO_Z_UP, SourceMotion, unscaled_rotations
from ..motion.up import BY_ITSELF, Ups
from ..rotations import smallest_rotation, unit
from .bone_maps import best_match, missing_joints
from .retarget import refuse_four_legs
from .structure_match import match_by_structure

STANDING = np.cos(np.radians(50))
"""Least cosine in a person's rest pose, of legs to the direction off the trunk, and of shoulders to hips."""

STRAIGHT = np.cos(np.radians(15))
"""Elbows and knees of a rest pose that was drawn as one are bent by less."""

LEANING = np.cos(np.radians(20))
"""A rest pose whose trunk leans by less stands on its feet."""

FLAT = np.cos(np.radians(8))
"""Feet tilted by less than this are flat."""

LOW_PERCENTILE = 25
SHANK_UPRIGHT = np.cos(np.radians(30))
"""A foot is stood on in frames where its ankle is as low as this and its shank as upright."""

AXES: tuple[Up, ...] = ("y", "z")
"""Axes that are up in BVH files, that of the format first."""

SAMPLES = 400
"""Frames looked at for a rest pose."""


def repaired(source: SourceMotion, up: Up | None = None, ups: Ups = BY_ITSELF) -> SourceMotion:
    """A BVH file's motion without T-poses at its ends, z up, with a rest pose that people can take.

    `source` has the file's y axis up; `up` is the one that is, where it is known, and `ups` are those of its
    library. It comes back as it is where nothing is wrong, or where the skeleton is not understood.
    """
    matched = best_match(source.bones)[1]
    if missing_joints(matched):
        matched = match_by_structure(source)
    if missing_joints(matched):
        return stood(source, up or "y", "y")
    clean = _moving(source, matched)
    led_by_pose = clean.first_frame > 0 and _standing(_places(source.matrices[0], matched))
    first = source.matrices[0]
    up, guess = (up, "") if up else _file_up(clean, matched, [first, source.rest][not led_by_pose :], ups)
    clean, whole = (replace(stood(motion, up, "y"), up_guessed=guess) for motion in (clean, source))
    if not _standing(_places(clean.rest, matched)):
        refuse_four_legs(clean, matched)
        rest = whole.matrices[0] if led_by_pose else _straightest(clean, matched)
        clean = replace(clean, rest=rest, rest_is_known=led_by_pose)
    clean = replace(clean, rest=_upright(clean.rest, matched))
    return replace(clean, rest=flat_footed(clean, matched))


def _moving(source: SourceMotion, matched: dict[int, int]) -> SourceMotion:
    """The motion without rest poses at its ends."""
    bones = [bone for _, bone in sorted(matched.items())]
    body = [bone for joint, bone in sorted(matched.items()) if joint not in BODY_HANDS]

    def resting(frames: list[int]) -> np.ndarray:
        turned, rest = (unscaled_rotations(m) for m in (source.matrices[frames][:, body], source.rest[body]))
        return shows_rest(turned, rest)

    part = moving_part(source.matrices[:, bones][..., :3, 3], resting, source.rate)
    cut = cut_words(part, source.n_frames, REST_POSE)
    return replace(source, matrices=source.matrices[part], first_frame=part.start, cut=cut)


def _file_up(
    source: SourceMotion, matched: dict[int, int], poses: Sequence[np.ndarray], ups: Ups
) -> tuple[Up, str]:
    """The file's own axis that is up: by the first of some rest poses that stands along one, or by `ups`.

    The format is y up, but some files, such as Blender's, are z up, and so is their rest pose. Twice if only
    by how people stand.
    """
    standing = [places for pose in poses if _standing(places := _places(pose, matched))]
    trunks = [unit(trunk_line(places)) @ TO_Z_UP[:3, :3] for places in standing]
    told: list[Up] = [up for trunk in trunks for up in AXES if trunk[UPS.index(up)] > LEANING]

    def look() -> Sight:
        frames = np.linspace(0, source.n_frames - 1, min(SEEN_FRAMES, source.n_frames)).astype(int)
        joints = source.matrices[frames][:, list(matched.values())][..., :3, 3] @ TO_Z_UP[:3, :3]
        return Sight.of_body(joints, {joint: number for number, joint in enumerate(matched)})

    skeleton = f"{crc32(repr((source.bones, source.parents.tolist())).encode()):08x}"
    kind = Kind("BVH", [*told, AXES[0]][0], firm=True, told=bool(told), skeleton=skeleton)
    return ups.with_guess(kind, look)


def _straightest(source: SourceMotion, matched: dict[int, int]) -> np.ndarray:
    """Rest matrices (B, 4, 4) from the frame most like standing straight, set upright with legs below."""
    frames = np.linspace(0, source.n_frames - 1, min(SAMPLES, source.n_frames)).astype(int)
    places = {joint: source.matrices[frames, bone, :3, 3] for joint, bone in matched.items()}
    bend = np.zeros(len(frames))
    trunk = unit(trunk_line(places))
    for side in ("left", "right"):
        for start, middle, end in (("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist")):
            a, b, c = (places[JOINT_INDEX[f"{side}_{part}"]] for part in (start, middle, end))
            bend += 1 - np.sum(unit(b - a) * unit(c - b), axis=-1)
        hip, ankle = (places[JOINT_INDEX[f"{side}_{part}"]] for part in ("hip", "ankle"))
        bend += 1 + np.sum(unit(ankle - hip) * trunk, axis=-1)
    best = int(bend.argmin())
    rest = _turned(source.matrices[frames[best]], trunk[best])
    for side in ("left", "right"):
        for start, end in (("hip", "knee"), ("knee", "ankle")):
            bone, tip = (matched[JOINT_INDEX[f"{side}_{part}"]] for part in (start, end))
            _hang(rest, source.parents, bone, tip)
    return rest


def _upright(rest: np.ndarray, matched: dict[int, int]) -> np.ndarray:
    """Rest matrices on their feet: some offsets are z-up and the root's rotation makes up for it."""
    trunk = unit(trunk_line(_places(rest, matched)))
    if trunk[2] > LEANING:
        return rest
    longest = np.abs(trunk).argmax()
    axis = np.sign(trunk) * (np.arange(3) == longest)
    return _turned(rest, axis if abs(trunk[longest]) > LEANING else trunk)


def _turned(matrices: np.ndarray, up: np.ndarray) -> np.ndarray:
    """All bones turned together until a direction points up."""
    turn = np.eye(4)
    turn[:3, :3] = smallest_rotation(up, np.array([0.0, 0.0, 1.0]))
    return turn @ matrices


def _hang(rest: np.ndarray, parents: np.ndarray, bone: int, tip: int) -> None:
    """Turn a bone and all that hang on it until its tip is straight below it, in place."""
    moved = np.arange(len(parents)) == bone
    for other in range(bone + 1, len(parents)):
        moved[other] = moved[other] or moved[parents[other]]
    pivot = rest[bone, :3, 3].copy()
    turn = smallest_rotation(rest[tip, :3, 3] - pivot, np.array([0.0, 0.0, -1.0]))
    rest[moved, :3, :3] = turn @ rest[moved, :3, :3]
    rest[moved, :3, 3] = pivot + (rest[moved, :3, 3] - pivot) @ turn.T


def flat_footed(source: SourceMotion, matched: dict[int, int]) -> np.ndarray:
    """Rest matrices whose feet are as they are when the body stands on them.

    Retargeting takes the feet of a rest pose for flat. Offsets alone do not make them so (CMU's legs
    are splayed and the feet with them), nor does a frame that was chosen for its limbs.
    """
    rest = source.rest.copy()
    for side in ("left", "right"):
        knee, ankle = (matched[JOINT_INDEX[f"{side}_{part}"]] for part in ("knee", "ankle"))
        toe = matched.get(JOINT_INDEX[f"{side}_foot"])
        if toe is None:
            continue
        frame = _on_its_foot(source.matrices[:, [knee, ankle, toe]][..., :3, 3])
        if frame is None:
            continue
        stance, resting = (unscaled_rotations(m[[ankle, toe]]) for m in (source.matrices[frame], source.rest))
        if (stance[0] @ resting[0].T)[2, 2] > FLAT:
            continue
        step = source.matrices[frame, toe, :3, 3] - source.matrices[frame, ankle, :3, 3]
        was = source.rest[toe, :3, 3] - source.rest[ankle, :3, 3]
        turn = np.arctan2(was[1], was[0]) - np.arctan2(step[1], step[0])
        yaw = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1.0]])
        rest[[ankle, toe], :3, :3] = yaw @ stance
        rest[toe, :3, 3] = rest[ankle, :3, 3] + yaw @ step
    return rest


def _on_its_foot(heads: np.ndarray) -> int | None:
    """The frame in which a foot stands stillest, of heads (T, 3, 3) of knee, ankle and toe."""
    low = heads[:, 1, 2] <= np.percentile(heads[:, 1, 2], LOW_PERCENTILE)
    under = unit(heads[:, 0] - heads[:, 1])[:, 2] > SHANK_UPRIGHT
    speed = np.linalg.norm(np.gradient(heads[:, 1:], axis=0), axis=-1).max(axis=1)
    standing = np.flatnonzero(low & under)
    return int(standing[speed[standing].argmin()]) if len(standing) else None


def rests_straight(source: SourceMotion) -> bool:
    """Whether a rest pose stands with straight arms and legs, as a T-pose does and few frames of a motion."""
    matched = best_match(source.bones)[1]
    if missing_joints(matched):
        return False
    places = _places(source.rest, matched)
    bends = []
    for side in ("left", "right"):
        for limb in (("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist")):
            start, middle, end = (places[JOINT_INDEX[f"{side}_{part}"]] for part in limb)
            bends.append(unit(middle - start) @ unit(end - middle))
    return _standing(places) and min(bends) > STRAIGHT


def are_rest_pose(bones: Sequence[str], heads: np.ndarray) -> bool:
    """Whether places (B, 3) of bones are a pose that a person can rest in, as far as their names tell."""
    matched = best_match(bones)[1]
    return not missing_joints(matched) and _standing({joint: heads[bone] for joint, bone in matched.items()})


def _standing(places: dict[int, np.ndarray]) -> bool:
    """Whether a pose is one that a person can rest in: legs below the trunk, shoulders along hips."""
    trunk = unit(trunk_line(places))
    legs = [
        unit(places[JOINT_INDEX[f"{side}_{end}"]] - places[JOINT_INDEX[f"{side}_{start}"]])
        for side in ("left", "right")
        for start, end in (("hip", "knee"), ("knee", "ankle"))
    ]
    across = [
        unit(places[JOINT_INDEX[f"left_{part}"]] - places[JOINT_INDEX[f"right_{part}"]])
        for part in ("hip", "shoulder")
    ]
    return bool(min(-leg @ trunk for leg in legs) > STANDING and across[0] @ across[1] > STANDING)


def _places(matrices: np.ndarray, matched: dict[int, int]) -> dict[int, np.ndarray]:
    return {joint: matrices[bone, :3, 3] for joint, bone in matched.items()}
