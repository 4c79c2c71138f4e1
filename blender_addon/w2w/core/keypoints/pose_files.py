# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint positions from video (csv, npy, npz, json), and joint centres of C3D files, read by ezc3d."""

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..body.body import Body
from ..files import array_names, read_arrays, read_npy
from ..motion.sight import UPS, Kind, Up
from ..motion.smpl_layouts import chosen_person
from ..motion.source import (
    SAY_RATE,
    UnusableMotion,
    reading,
    refuse_few_frames,
    refuse_long_array,
    refuse_too_long,
    size_and_head,
    usable_rate,
)
from ..motion.up import BY_ITSELF, Ups
from ..pickles import read_npy_object
from ..wording import clean, restated
from .facts import IN_FILES, POSITION_KEYS, SPELLINGS, UNITS, PoseFacts, facts_of, side_car_facts
from .fit import CUTOFF_HZ, KeypointFit, fit_keypoints, seen_joints
from .joint_sets import JOINT_SETS, JointSet
from .naming import FEATURES, RawPose, joint_set_of, plain_joint
from .paths import REQUIRED
from .pose_text import read_csv_pose, read_json_pose, read_trc_pose

C3D_JOINTS = "joint-centres"

C3D_LABELS = {
    "HJC": "hip", "KJC": "knee", "AJC": "ankle", "SJC": "shoulder", "EJC": "elbow", "WJC": "wrist",
    "FEP": "hip", "FEO": "knee", "TIO": "ankle", "HUP": "shoulder", "HUO": "elbow", "RAO": "wrist",
    "HNO": "hand", "TOE": "toe", "FIN": "hand",
}  # fmt: skip
"""Labels after their L or R: joint centres (CGM, Theia, Visual3D), the segments' ends that Plug-in Gait
writes (a femur's P is the hip, its O the knee), and the markers of toe and finger."""

C3D_MIDDLE = {"HEDO": "head", "C7": "neck"}


def read_c3d_pose(path: Path) -> RawPose:
    """Joint centres, or else origins of segments (Theia's), rate and unit of a C3D file.

    Raises UnusableMotion if ezc3d is missing, the file is damaged or holds markers alone.
    """
    with restated("C3D files are read by ezc3d (pip install ezc3d):", ImportError, UnusableMotion):
        import ezc3d
    try:
        content = ezc3d.c3d(str(path))
        point = content["parameters"]["POINT"]
        labels = [str(label) for label in point["LABELS"]["value"]]
        rate = float(np.ravel(point["RATE"]["value"])[0])
        unit = str(next(iter(point["UNITS"]["value"]), "")).strip().lower()
        screen = str(next(iter(point.get("Y_SCREEN", {}).get("value", ())), "")).strip().lower().lstrip("+")
        positions = np.asarray(content["data"]["points"])[:3].transpose(2, 1, 0)
        turned = np.asarray(content["data"]["rotations"])  # (4, 4, segments, frames)
        segments = content["parameters"].get("ROTATION", {}).get("LABELS", {}).get("value", ())
    except (OSError, KeyError, ValueError, IndexError, RuntimeError, StopIteration) as error:
        raise UnusableMotion(f"it cannot be read as C3D: {str(error).splitlines()[0]}") from error
    facts = PoseFacts(
        rate if rate > 0 else None, unit if unit in UNITS else None, screen if screen in UPS else None
    )
    raw = RawPose(positions, tuple(labels[: positions.shape[1]]), facts)
    if segments and not set(REQUIRED) <= set(map(_joint, raw.names)):
        names = tuple(re.sub("_4X4$", "", str(name), flags=re.IGNORECASE) for name in segments)
        places = turned[:3, 3].transpose(2, 1, 0)
        faster = len(places) / max(len(positions), 1)
        return RawPose(places, names, replace(facts, rate=facts.rate and facts.rate * faster))
    return _joint_centres(raw)


def _read_trc(path: Path) -> RawPose:
    """Joints of a trc file: under names of a joint set, or as centres like those of C3D."""
    raw = read_trc_pose(path)
    return raw if set(REQUIRED) <= set(map(plain_joint, raw.names)) else _joint_centres(raw)


def _joint_centres(raw: RawPose) -> RawPose:
    """The joint centres among labelled points; UnusableMotion if hips or shoulders are missing."""
    names: dict[str, int] = {}
    for number, label in enumerate(raw.names):
        names.setdefault(_joint(label), number)
    missing = [name for name in REQUIRED if name not in names]
    if missing:
        held = ", ".join(raw.names[:8]) + (", ..." if len(raw.names) > 8 else "") or "nothing"
        raise UnusableMotion(
            f"it names no joint centre of the {', '.join(missing)} (such as LHJC, LSJC), and holds {held}: "
            "W2W reads joint centres, not markers; let your gait model write them"
        )
    chosen = [joint for joint in JOINT_SETS[C3D_JOINTS].joints if plain_joint(joint) in names]
    places = [names[plain_joint(joint)] for joint in chosen]
    return RawPose(raw.positions[:, places], tuple(chosen), replace(raw.facts, joint_set=C3D_JOINTS))


def _joint(label: str) -> str:
    """The plain name of a label's joint: ``Anna:LHJC`` is the left hip."""
    plain = label.rpartition(":")[2].strip()
    upper = plain.upper()
    if upper in C3D_MIDDLE:
        return C3D_MIDDLE[upper]
    if upper[:1] in ("L", "R") and upper[1:] in C3D_LABELS:
        return f"{'left' if upper[0] == 'L' else 'right'} {C3D_LABELS[upper[1:]]}"
    return plain_joint(plain)


MAX_BYTES = 2 * 2**30
MAX_DISTANCE = 1e9
"""Farthest position, in the file's own unit, which may be millimetres."""

SHORTEST_M, TALLEST_M = 0.4, 2.6
"""Heights of people, from infants on; others are in another unit."""

LONGEST_UNSEEN_S = 0.5
"""Longest time without hips and shoulders that is bridged: a step takes as long, and beyond it a motion would
be invented."""

USUAL_UP: dict[str, Up] = {
    **dict.fromkeys(("human36m-17", C3D_JOINTS), "z"),
    **dict.fromkeys(("azure-kinect-32", "blazepose-33", "mhr-70", "mhr-127"), "-y"),
}
"""Axes that are up in a joint set's own world or camera, if not y."""

CAMERA = "pred_cam_t"
"""SAM 3D Body's path of the person; its joints are against that."""

PROGRAMS: dict[str, Up] = {"posed_joints": "y", "pred_joint_coords": "-y", "pred_keypoints_3d": "-y"}
"""Axes that are up under a program's own names: Kimodo's world, and SAM 3D Body's camera."""

NO_FACTS = PoseFacts()

FACT_KEYS = (*sorted(IN_FILES), *SPELLINGS)


@dataclass(frozen=True, eq=False)
class JointPositions:
    """A clip as the positions of joints."""

    positions: np.ndarray  # (T, J, 3) in the file's axes and unit; NaN where a joint was not seen
    rate: float
    joint_set: JointSet
    unit: str  # "" if unknown
    up: Up
    up_guessed: str  # the same axis, if that is assumed
    people: int = 1  # in the file, of whom this is one

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.positions)

    def fit(self, body: Body, cutoff_hz: float = CUTOFF_HZ) -> KeypointFit:
        """The motion of a body that moves like these joints, whose paths' band is limited.

        Raises UnusableMotion if there is no body in them, or none of a human's size in their unit.
        """
        with reading(ValueError, np.linalg.LinAlgError):
            fitted = fit_keypoints(self.positions, self.rate, self.joint_set, body, self.up, cutoff_hz)
        height = self.height(body, fitted)
        if height is not None and not SHORTEST_M <= height <= TALLEST_M:
            raise UnusableMotion(
                f"in '{self.unit}' its person would be {height:.3g} m tall: correct its unit (--pose-unit)"
            )
        return fitted

    def height(self, body: Body, fitted: KeypointFit) -> float | None:
        """The person's approximate height, m, from the lengths of the limbs; None if the unit is unknown."""
        return body.height * UNITS[self.unit] / fitted.scale if self.unit else None


def read_joints(path: Path, given: PoseFacts = NO_FACTS, ups: Ups = BY_ITSELF) -> JointPositions:
    """Read joint positions: csv (columns ``left_hip_x``, ...), npy or npz (T, J, 3), json or c3d.

    The file is one that `is_joint_file` knows by its suffix. Facts that it lacks may lie in
    ``NAME.json`` next to it; `given` take precedence. If nothing says which axis is up, `ups` decide
    for a library's files.

    Raises UnusableMotion, with the reason, if it is another file, or its rate or joints are not known.
    """
    size_and_head(path)
    with reading(ValueError, MemoryError):
        raw = _READERS[path.suffix.lower()](path)
    raw = raw._replace(facts=raw.facts.completed(side_car_facts(path)))
    return joints_of(raw, given, ups, clean(path.with_suffix(".json").name))


def joints_of(raw: RawPose, given: PoseFacts, ups: Ups = BY_ITSELF, side_car: str = "") -> JointPositions:
    """Joint positions from a file's or a user's arrays; facts that are given go before its own.

    The `side_car` may say the rate. Raises UnusableMotion, with the reason, as `read_joints` does.
    """
    facts = given.completed(raw.facts)
    people = _people(raw.positions)
    raw = raw._replace(positions=chosen_person(people, facts.person))
    if raw.positions.ndim < 2:
        raise UnusableMotion(f"it has shape {raw.positions.shape}; joint positions have (frames, joints, 3)")
    refuse_too_long(len(raw.positions), max(1, raw.positions.shape[1]))
    if facts.rate is None:
        beside = f', or "rate" in {side_car} next to it' if side_car else ""
        raise UnusableMotion(f"it does not say its frame rate: give {SAY_RATE}{beside}")
    rate = usable_rate(facts.rate, given.rate)
    joint_set, positions, left_handed = joint_set_of(raw, facts.joint_set)
    positions = _seen(positions)
    refuse_few_frames(len(positions))
    _refuse_unseen(positions, joint_set, rate)
    told = raw.up or ("y" if raw.positions.ndim == 2 and raw.positions.shape[1] in FEATURES else None)
    usual = told or {JOINT_SETS[key].name: up for key, up in USUAL_UP.items()}.get(joint_set.name, "y")
    kind = Kind(f"joints ({joint_set.name})", usual, raw.firm, told is not None, UPS)
    up, guess = facts.up, ""
    if up is None:
        with reading(ValueError):
            up = ups.of(kind, seen := seen_joints(positions, joint_set))
        guess = ups.guess(kind, seen, up)
    if left_handed:
        positions[..., int(up[-1] == "x")] *= -1
    return JointPositions(positions, rate, joint_set, facts.unit or "", up, guess, len(people))


def _people(array: np.ndarray) -> list[np.ndarray]:
    """Positions of each person of an array (T, P, J, 3) or (P, T, J, 3), whoever is seen longest first."""
    if array.ndim != 4 or array.dtype.kind not in "fiu":
        return [array]
    people = [*array] if len(array) < array.shape[1] else [*array.swapaxes(0, 1)]
    return sorted(people, key=lambda each: -np.count_nonzero(np.isfinite(each) & (each != 0)))


def _seen(positions: np.ndarray) -> np.ndarray:
    """Positions, NaN for joints not seen: those not finite, or 0, 0, 0 in some frames."""
    positions = positions.astype(np.float64)
    positions[~np.isfinite(positions).all(axis=2)] = np.nan
    if np.abs(positions[np.isfinite(positions)]).max(initial=0.0) > MAX_DISTANCE:
        raise UnusableMotion("its positions reach beyond any unit of length: it is damaged")
    nought = (positions == 0).all(axis=2)
    positions[nought & ~nought.all(axis=0)] = np.nan  # a joint at 0 throughout is the origin
    return positions


def _refuse_unseen(positions: np.ndarray, joint_set: JointSet, rate: float) -> None:
    """Refuse positions (T, J, 3) in which neither hips nor shoulders are seen for longer than is bridged."""
    trunk = [joint for part in REQUIRED for joint in joint_set.members(part)]
    seen = np.flatnonzero(np.isfinite(positions[:, trunk]).any(axis=(1, 2)))
    edges = np.array([-1, *seen, len(positions)])
    longest = int(np.diff(edges).argmax())
    start, stop = (edges[longest] + 1) / rate, edges[longest + 1] / rate
    if len(seen) and stop - start > LONGEST_UNSEEN_S:
        raise UnusableMotion(
            f"its hips and shoulders are not seen from {start:.2f} s to {stop:.2f} s; gaps are bridged up to "
            f"{LONGEST_UNSEEN_S:g} s: cut it there"
        )


def _read_npz(path: Path) -> RawPose:
    names = array_names(path)
    key = next((key for key in POSITION_KEYS if key in names), None)
    if key is None:
        held = ", ".join(sorted(names)[:8]) or "nothing"
        raise UnusableMotion(f"it holds {held}, and none of {', '.join(POSITION_KEYS)}")
    arrays = read_arrays(path, (key, CAMERA, *FACT_KEYS), MAX_BYTES, refuse_long_array)
    facts = {name: arrays[name].item() for name in FACT_KEYS if name in arrays and arrays[name].size == 1}
    positions = arrays[key]
    if key.startswith("pred_") and CAMERA in arrays and arrays[CAMERA].shape == (len(positions), 3):
        positions = positions + arrays[CAMERA][:, None]
    if key == "posed_joints" and positions.shape[-2:-1] == (34,):
        raise UnusableMotion("its 34 joints are those of a robot, Unitree's G1: take a person's skeleton")
    return RawPose(positions, (), facts_of(facts), PROGRAMS.get(key))


def _read_npy(path: Path) -> RawPose:
    content = read_npy_object(path)
    if content is None:
        return RawPose(read_npy(path, refuse_long_array), (), NO_FACTS)
    motion = content.get("motion") if isinstance(content, dict) else None
    if not isinstance(motion, np.ndarray) or motion.ndim != 4 or motion.shape[2] != 3:
        held = ", ".join(map(str, content)) if isinstance(content, dict) else type(content).__name__
        raise UnusableMotion(
            f"it holds a pickled object ({clean(held[:80])}), no array of positions nor a result of motion "
            "diffusion ('motion' of clips, joints, 3, frames)"
        )
    if len(motion) != 1:
        raise UnusableMotion(
            f"it holds {len(motion)} motions, as motion diffusion writes them: save each one's positions "
            "(frames, joints, 3) as an npy file of its own"
        )
    length = np.ravel(content.get("lengths", ()))  # what comes after it fills up
    frames = int(length[0]) if length.size and length.dtype.kind in "iu" else motion.shape[3]
    return RawPose(motion[0].transpose(2, 0, 1)[:frames], (), NO_FACTS, "y")


_READERS = {
    ".c3d": read_c3d_pose,
    ".csv": read_csv_pose,
    ".json": read_json_pose,
    ".npy": _read_npy,
    ".npz": _read_npz,
    ".trc": _read_trc,
}
