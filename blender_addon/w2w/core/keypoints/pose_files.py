# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint positions from video, as csv, npy, npz or json files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..body.body import Body
from ..file_names import shown
from ..files import array_names, read_arrays, read_npy
from ..motion.joint_files import POSITION_KEYS
from ..motion.motion_file import size_and_head, unreadable
from ..motion.source import UnusableMotion, reason_of, refuse_rate, refuse_too_long
from .facts import UNITS, PoseFacts, facts_of, side_car_facts
from .fit import KeypointFit, Up, fit_keypoints, guess_up
from .joint_sets import JointSet
from .naming import told_by
from .pose_c3d import read_c3d_pose
from .pose_text import RawPose, read_csv_pose, read_json_pose

MAX_BYTES = 2 * 2**30
MIN_FRAMES = 4
MAX_DISTANCE = 1e9
"""In the file's own unit, which may be millimetres."""

SHORTEST_M, TALLEST_M = 0.4, 2.6
"""People, from infants on; whoever is smaller or taller is in another unit."""

NO_FACTS = PoseFacts()

FACT_KEYS = (
    "rate", "fps", "framerate", "frame_rate", "mocap_framerate", "rate_hz", "unit", "units", "up", "up_axis",
    "joint_set", "skeleton",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class JointPositions:
    """A clip as the positions of joints.

    Parameters
    ----------
    positions : ndarray, shape (T, J, 3)
        In the file's axes and unit; NaN where a joint was not seen.
    rate : float
        Frames per second.
    joint_set : JointSet
    unit : str
        Empty where unknown.
    up : {"x", "y", "z", "-x", "-y", "-z"}
    up_is_guessed : bool
        By where the trunk points, not by the file's word.
    """

    positions: np.ndarray
    rate: float
    joint_set: JointSet
    unit: str
    up: Up
    up_is_guessed: bool

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.positions)

    def fit(self, body: Body) -> KeypointFit:
        """The motion of a body that moves like these joints.

        Raises
        ------
        UnusableMotion
            If there is no body in them, or none of a human's size in their unit.
        """
        try:
            found = fit_keypoints(self.positions, self.rate, self.joint_set, body, self.up)
        except (ValueError, np.linalg.LinAlgError) as error:
            raise UnusableMotion(reason_of(error)) from error
        height = self.height(body, found)
        if height is not None and not SHORTEST_M <= height <= TALLEST_M:
            raise UnusableMotion(
                f"in '{self.unit}' its person would be {height:.3g} m tall: correct its unit (--pose-unit)"
            )
        return found

    def height(self, body: Body, found: KeypointFit) -> float | None:
        """About how tall the person is, m, by the lengths of the limbs; None where the unit is unknown."""
        return body.height * UNITS[self.unit] / found.scale if self.unit else None


def read_joints(path: str | Path, given: PoseFacts = NO_FACTS) -> JointPositions:
    """Read joint positions.

    Parameters
    ----------
    path : str or Path
        csv (columns ``left_hip_x``, ...), npy or npz (T, J, 3), or json. What the file does not say itself
        may stand in ``NAME.json`` beside it.
    given : PoseFacts
        What is known better than by the file.

    Raises
    ------
    UnusableMotion
        If it is no such file, or its rate or joints are not known; the message says why.
    """
    path = Path(path)
    size_and_head(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise UnusableMotion(f"'{path.suffix}' is no kind of file that joint positions come in")
    try:
        raw = reader(path)
    except OSError as error:
        raise UnusableMotion(unreadable(error)) from error
    except (ValueError, MemoryError) as error:
        raise UnusableMotion(reason_of(error)) from error
    facts = given.completed(raw.facts).completed(side_car_facts(path))
    if raw.positions.ndim < 2:
        raise UnusableMotion(f"it has shape {raw.positions.shape}; joint positions have (frames, joints, 3)")
    refuse_too_long(len(raw.positions), max(1, raw.positions.shape[1]))
    if facts.rate is None:
        raise UnusableMotion(
            'it does not say its frame rate: give --pose-rate, or "rate" in '
            f"{shown(path.with_suffix('.json').name)} beside it"
        )
    refuse_rate(facts.rate)
    joint_set, positions = told_by(raw, facts.joint_set)
    positions = _seen(positions)
    if len(positions) < MIN_FRAMES:
        plural = "s" * (len(positions) != 1)
        raise UnusableMotion(f"it holds a pose, not a motion: {len(positions)} frame{plural}")
    try:
        up = facts.up or guess_up(positions, joint_set)
    except ValueError as error:
        raise UnusableMotion(reason_of(error)) from error
    return JointPositions(positions, facts.rate, joint_set, facts.unit or "", up, facts.up is None)


def _seen(positions: np.ndarray) -> np.ndarray:
    """Positions, NaN where a joint was not seen: where it is not finite, or 0, 0, 0 in some frames."""
    positions = positions.astype(np.float64)
    positions[~np.isfinite(positions).all(axis=2)] = np.nan
    if np.abs(positions[np.isfinite(positions)]).max(initial=0.0) > MAX_DISTANCE:
        raise UnusableMotion("its positions reach beyond any unit of length: it is damaged")
    nought = (positions == 0).all(axis=2)
    positions[nought & ~nought.all(axis=0)] = np.nan  # a joint at 0 throughout is the origin
    return positions


def _read_npy(path: Path) -> RawPose:
    return RawPose(read_npy(path), (), PoseFacts())


def _read_npz(path: Path) -> RawPose:
    names = array_names(path)
    key = next((key for key in POSITION_KEYS if key in names), None)
    if key is None:
        held = ", ".join(sorted(names)[:8]) or "nothing"
        raise UnusableMotion(f"it holds {held}, and none of {', '.join(POSITION_KEYS)}")
    arrays = read_arrays(path, (key, *FACT_KEYS), MAX_BYTES)
    facts = {name: arrays[name].item() for name in FACT_KEYS if name in arrays and arrays[name].size == 1}
    return RawPose(arrays[key], (), facts_of(facts))


_READERS = {
    ".c3d": read_c3d_pose,
    ".csv": read_csv_pose,
    ".json": read_json_pose,
    ".npy": _read_npy,
    ".npz": _read_npz,
}
