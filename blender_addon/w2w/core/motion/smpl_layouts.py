# SPDX-License-Identifier: GPL-3.0-or-later
"""SMPL parameters as pose estimators and data sets write them, under the names and in the form of smplx."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from ..files import npy_shape
from ..wording import clean, restated
from .source import UnusableMotion

IN_PARTS = ("global_orient", "body_pose")
WHOLE = {
    "smpl_poses": "smpl_trans",
    "pose_world": "trans_world",
    "pred_rotmat": "pred_trans",
    "pose": "trans",
}
"""Array of all joints' rotations -> array of the body's path: of AIST++, WHAM's world, TRAM and VIMO, and
WHAM's camera, PromptHMR and CoMotion."""

RENAMED = {
    "fullpose": "poses", "pose_est_fullposes": "poses", "pose_est_trans": "trans",
    "poses_root": IN_PARTS[0], "poses_body": IN_PARTS[1], "gt": "pose",
}  # fmt: skip
"""Other names in results: MoSh++'s and MoSh's, EMDB's, and DIP-IMU's."""

AT_60_HZ = {"poses_60Hz": "pose", "trans_60Hz": "trans"}
"""3DPW's arrays at the rate of its sensors (von Marcard et al. 2018); its others are frames of the video."""

POSES = {*WHOLE, *RENAMED, "poses", "pose_body", IN_PARTS[1]}
PATHS = ("trans", "transl", *WHOLE.values())
NAMED = {*POSES, *PATHS, *AT_60_HZ, IN_PARTS[0], "root_orient"}
"""Names of poses, and of the body's path, in results."""

SCALE = "smpl_scaling"
"""AIST++ divides its path by it: what is left is in metres (Li et al. 2021, its own loader)."""

RESULT_KEYS = (*WHOLE, *WHOLE.values(), SCALE)

RESULT_SUFFIXES = (".pkl", ".pt", ".pth")
"""Kinds of files in which estimators leave their results as pickles."""

MOTION_X = {"global_orient": slice(3), "body_pose": slice(3, 66), "transl": slice(309, 312)}
"""Places in Motion-X's 322 numbers a frame (Lin et al. 2023); the rest is of hands, face and shape."""

MOTION_X_NUMBERS = 322

Chosen = TypeVar("Chosen")

Person = tuple[tuple[str, ...], dict[str, np.ndarray]]

DEEPEST = 5

NOT_ORTHOGONAL = 0.01

NO_TRACKS = (KeyError, TypeError, ValueError)
"""Errors of tracks that are something else."""


def in_smplx_form(arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Arrays with rotation matrices made axis-angle, results renamed, and a path of 0 if there is none.

    Files of AMASS and `.smpl` files stay as they are. Raises UnusableMotion if matrices do not rotate.
    """
    renamed = {name: _axis_angle(name, array) for name, array in arrays.items()}
    whole = next((name for name in WHOLE if name in renamed), "")
    if whole and "poses" not in renamed and renamed[whole].ndim > 1:
        turns = renamed[whole].reshape(len(renamed[whole]), -1)
        renamed |= dict(zip(IN_PARTS, (turns[:, :3], turns[:, 3:]), strict=True))
        path = renamed.get(WHOLE[whole])
        renamed.pop("trans", None)  # of WHAM's camera, or that path
        if path is not None:
            renamed["transl"] = _path(path, renamed.get(SCALE))
    if renamed.keys() >= set(IN_PARTS) and renamed[IN_PARTS[0]].ndim > 1:
        renamed.setdefault("transl", np.zeros((len(renamed[IN_PARTS[0]]), 3)))
    return renamed


def is_motion_x(path: Path) -> bool:
    """Whether a file is an npy of Motion-X's numbers."""
    shape = npy_shape(path) if path.suffix.lower() == ".npy" else ()
    return len(shape) == 2 and shape[1] == MOTION_X_NUMBERS


def people_in_result(content: Any) -> list[dict[str, np.ndarray]]:
    """The arrays of each person of a result, whoever is seen longest first, in the world if that is there.

    Raises UnusableMotion if it holds no poses of SMPL.
    """
    with restated("it is damaged: its tracks hold no poses of SMPL", NO_TRACKS, UnusableMotion):
        found = [*_tracks(content)] or [*_people(content, (), set())]
    if not found:
        held = ", ".join(map(str, content)) if isinstance(content, dict) else type(content).__name__
        raise UnusableMotion(f"it holds no poses of SMPL, but {clean(held[:120])}")
    in_world = [item for item in found if _in_world(*item)]
    people = sorted((arrays for _, arrays in in_world or found), key=_seen_frames, reverse=True)
    facts = _numbers(content, DEEPEST, set())
    return [facts | arrays for arrays in people]


def _numbers(value: Any, depth: int, seen: set[int]) -> dict[str, np.ndarray]:
    """Single numbers of nested dicts by name; the outer ones go before."""
    found: dict[str, np.ndarray] = {}
    if isinstance(value, dict) and depth and id(value) not in seen:
        seen.add(id(value))
        for part in value.values():
            found = _numbers(part, depth - 1, seen) | found
        single = {name: part for name, part in value.items() if isinstance(part, int | float | np.number)}
        found |= {str(name): np.asarray(part) for name, part in single.items()}
    return found


def chosen_person(people: Sequence[Chosen], person: int | None) -> Chosen:
    """One of some people by a number from 1 on, by default the first; UnusableMotion if there are fewer."""
    number = 1 if person is None else person
    if number > len(people):
        shows = "one person" if len(people) == 1 else f"{len(people)} people"
        raise UnusableMotion(f"it shows {shows}, and none is number {number} (--person)")
    return people[number - 1]


def _seen_frames(arrays: dict[str, np.ndarray]) -> int:
    return max(map(_frames, arrays.values()))


def _people(value: Any, names: tuple[str, ...], seen: set[int]) -> Iterator[Person]:
    """Whatever holds poses, at any depth, each with the names that lead there."""
    if id(value) in seen or len(names) > DEEPEST:
        return
    seen.add(id(value))
    for person in _apart(value) if isinstance(value, dict) else ():
        arrays = {name: array for name, array in person.items() if isinstance(array, np.ndarray)}
        if arrays.keys() & POSES and _seen_frames(arrays) > 1:
            yield names, {RENAMED.get(name, name): array for name, array in arrays.items()}
    parts = value.items() if isinstance(value, dict) else enumerate(value if isinstance(value, list) else ())
    for name, part in parts:
        if isinstance(part, dict | list):
            yield from _people(part, (*names, str(name)), seen)


def _apart(result: dict[Any, Any]) -> list[dict[str, Any]]:
    """A dict's content for each of its people: a list (3DPW), or the first axis of its arrays (CHI3D)."""
    named = {str(name): _array(part) if str(name) in NAMED else part for name, part in result.items()}
    rate = {}
    if named.keys() >= AT_60_HZ.keys():
        named = {name: named[own] for own, name in AT_60_HZ.items()}
        rate = {"frame_rate": np.array(60.0)}
    path = next((named[name] for name in PATHS if name in named), None)
    several = path.ndim == 3 and path.shape[1] > 1 if isinstance(path, np.ndarray) else isinstance(path, list)
    if path is None or not several:
        return [named]
    lists = {name: part for name, part in named.items() if isinstance(part, list | np.ndarray)}
    parts = {
        name: part for name, part in lists.items() if getattr(part, "ndim", 1) and len(part) == len(path)
    }
    return [{name: _array(part[one]) for name, part in parts.items()} | rate for one in range(len(path))]


def _array(value: Any) -> Any:
    """Lists of numbers, as deep as they are regular, as an array; anything else as it is."""
    if isinstance(value, list):
        with suppress(ValueError, TypeError, OverflowError):
            return np.array(value, dtype=np.float64)
    return value


def _in_world(names: tuple[str, ...], arrays: dict[str, np.ndarray]) -> bool:
    return "pose_world" in arrays or any("world" in name or "global" in name for name in names)


def _frames(array: np.ndarray) -> int:
    return len(array) if array.ndim > 1 else 0


def _tracks(content: Any) -> Iterator[Person]:
    """People of 4D-Humans: a dict a frame, with lists of track numbers and SMPL parameters side by side."""
    frames = list(content.values()) if isinstance(content, dict) else []
    if not all(isinstance(frame, dict) and {"tid", "smpl"} <= frame.keys() for frame in frames):
        return
    runs: dict[Any, list[dict[str, np.ndarray]]] = {}
    for frame in frames:
        here = dict(zip(frame["tid"], frame["smpl"], strict=False))
        for track in runs.keys() - here.keys():  # a gap ends it
            yield (), _stacked(runs.pop(track))
        for track, parameters in here.items():
            runs.setdefault(track, []).append(parameters)
    for run in runs.values():
        yield (), _stacked(run)


def _stacked(run: list[dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    return {name: np.stack([parameters[name] for parameters in run]) for name in IN_PARTS}


def _axis_angle(name: str, array: np.ndarray) -> np.ndarray:
    """Rotation matrices (T, J, 3, 3), or (T, 3, 3) of one joint, as rotation vectors (T, 3 J)."""
    if array.ndim < 3 or array.shape[-2:] != (3, 3) or array.dtype.kind != "f":
        return array
    turns = array.astype(np.float64)
    with np.errstate(invalid="ignore"):
        square = turns.swapaxes(-1, -2) @ turns
        if not (np.abs(square - np.eye(3)) < NOT_ORTHOGONAL).all() or (np.linalg.det(turns) < 0).any():
            raise UnusableMotion(f"its '{name}' have shape {array.shape}, and not all are rotation matrices")
    return Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_rotvec().reshape(len(turns), -1)


def _path(path: np.ndarray, scale: np.ndarray | None) -> np.ndarray:
    """The body's path (T, 3) in metres."""
    if path.ndim == 3 and path.shape[1] == 1:
        path = path[:, 0]
    if scale is None:
        return path
    if scale.size != 1 or scale.dtype.kind not in "fiu" or not float(scale.item()) > 0:
        raise UnusableMotion(f"its '{SCALE}' is no number above 0")
    return path / float(scale.item())
