# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions of the 24 joints; AMASS-style npz and `.smpl` files (SMPL, SMPL-H, SMPL-X poses) read as such."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import scipy
from scipy.spatial.transform import Rotation, RotationSpline

from ..body.body import BODY_HANDS, N_JOINTS, Y_UP_TO_Z_UP, Body, posed_joints
from ..files import array_names, read_arrays, read_npy, write_npz
from ..filtering import butterworth, count_resampled
from ..given import given_path
from ..pickles import read_result
from ..rotations import in_axes, rotation_vectors
from ..wording import in_python
from .sight import MOSTLY, SEEN_FRAMES, Kind, Sight, Up, turned
from .smpl_layouts import (
    MOTION_X,
    RESULT_KEYS,
    RESULT_SUFFIXES,
    chosen_person,
    in_smplx_form,
    is_motion_x,
    people_in_result,
)
from .source import (
    SAY_RATE,
    UnusableMotion,
    read_json,
    reading,
    refuse_degrees,
    refuse_few_frames,
    refuse_long_array,
    refuse_too_long,
    size_and_head,
    usable_rate,
)
from .up import BY_ITSELF, HEAD_DOWN, Ups

SMPL_PELVIS = np.array([-0.00179506, -0.22333382, 0.02821918])
"""Pelvis of SMPL's neutral template in its own y-up axes, metres: AMASS's ``trans`` is
measured from it (J_regressor @ v_template of the neutral model, Loper et al. 2015)."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Joint rotations and the pelvis's path, frame by frame.

    Parameters
    ----------
    rotations : ndarray, shape (T, 24, 3, 3), float64
        Rotation of each joint relative to its parent (of the pelvis: to the world), in
        the axes of the T-pose (z up, facing -y). Identity everywhere is the T-pose.
    pelvis : ndarray, shape (T, 3), float64
        World position of the pelvis joint, metres, z up.
    rate : float
        Frames per second.
    activity, subject, clip : str
        Label, person and name of the clip; "" if unknown.
    people : int
        People in the file that it was read from, of whom this is one.
    up_guessed : str
        Axis of the file that is taken as up, if that is assumed; else "".

    Raises
    ------
    ValueError
        If shapes disagree, a value is not finite, or the rate is not positive.

    Examples
    --------
    >>> t_pose = np.tile(np.eye(3), (60, 24, 1, 1))
    >>> w2w.Motion(t_pose, np.tile([0.0, 0.0, 0.95], (60, 1)), rate=30.0, activity="standing", clip="T-pose")
    <Motion 'T-pose', 'standing': 60 frames at 30 Hz>
    """

    rotations: np.ndarray
    pelvis: np.ndarray
    rate: float
    activity: str = ""
    subject: str = ""
    clip: str = ""
    people: int = 1
    up_guessed: str = ""

    def __repr__(self) -> str:
        return f"<Motion {self.clip!r}, {self.activity!r}: {self.n_frames} frames at {self.rate:g} Hz>"

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotations", np.ascontiguousarray(self.rotations, dtype=np.float64))
        object.__setattr__(self, "pelvis", np.ascontiguousarray(self.pelvis, dtype=np.float64))
        object.__setattr__(self, "rate", float(self.rate))
        n_frames = len(self.rotations)
        if self.rotations.shape != (n_frames, N_JOINTS, 3, 3) or n_frames == 0:
            raise ValueError(f"rotations must have shape (T, {N_JOINTS}, 3, 3), not {self.rotations.shape}")
        if self.pelvis.shape != (n_frames, 3):
            raise ValueError(f"pelvis must have shape ({n_frames}, 3), not {self.pelvis.shape}")
        if not (np.isfinite(self.rotations).all() and np.isfinite(self.pelvis).all()):
            raise ValueError("the motion holds values that are not finite")
        if not (np.isfinite(self.rate) and self.rate > 0):
            raise ValueError(f"the frame rate must be positive, not {self.rate}")

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.rotations)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.n_frames - 1) / self.rate

    @property
    def head_down(self) -> bool:
        """Whether the trunk points down in most frames."""
        return bool(np.mean(self.rotations[:, 0, 2, 2] < HEAD_DOWN) > MOSTLY)

    def labelled(self, activity: str, subject: str, clip: str) -> Motion:
        """The same motion under another label."""
        return replace(self, activity=activity, subject=subject, clip=clip)

    def save(self, path: str | Path) -> None:
        """Write an AMASS-style npz, with W2W's labels.

        ``poses`` (T, 72) are axis-angle in SMPL's axes, ``trans`` (T, 3) metres, z up; ``mocap_framerate``.
        """
        in_smpl_axes = in_axes(self.rotations, Y_UP_TO_Z_UP)
        in_smpl_axes[:, 0] = self.rotations[:, 0] @ Y_UP_TO_Z_UP
        poses = rotation_vectors(in_smpl_axes).reshape(self.n_frames, -1)
        moved = {"poses": poses, "trans": self.pelvis - SMPL_PELVIS}
        facts = {"mocap_framerate": np.array(self.rate), "gender": np.array("neutral"), "betas": np.zeros(10)}
        write_npz(path, moved | facts | {name: np.array(getattr(self, name)) for name in LABELS})

    @classmethod
    def load(
        cls,
        path: str | Path,
        rate: float | None = None,
        up: Up | None = None,
        person: int | None = None,
    ) -> Motion:
        """Read a motion of the 24 joints: a file of `save`, labels included, or an AMASS or SMPL npz.

        `rate` and the axis `up` take precedence over the file's own; `person` is as for `read_amass`.

        Raises
        ------
        ValueError
            If it is no such file; the message says why.
        """
        path = given_path(path, "a motion")
        try:
            return _labelled(path, rate, up, BY_ITSELF, person)
        except (UnusableMotion, ValueError) as error:
            why = in_python(str(error), "{}=...")
            raise ValueError(f"{path} cannot be read as a motion: {why}") from error


LABELS = ("activity", "subject", "clip")
"""Arrays that `Motion.save` adds to those of AMASS."""

RATE_KEYS = ("mocap_framerate", "mocap_frame_rate", "framerate", "frame_rate", "fps", "frameRate")
TRANS_KEYS = ("trans", "transl", "bodyTranslation")
POSE_KEYS = (("poses",), ("bodyPose",), ("root_orient", "pose_body"), ("global_orient", "body_pose"))
"""Names of the poses in AMASS and in `.smpl` files (Meshcapade's smplcodec, an npz by other names), or of the
pelvis's turn and the other joints', in files that keep them apart."""

AMASS, SMPLX = Kind("AMASS", "z", firm=True), Kind("SMPL-X", "y")
"""Kinds by the names of their arrays: AMASS's world is z up, and files with smplx's names have any."""

BODY_JOINTS = min(BODY_HANDS)
"""Joints before the hands: the same in SMPL, SMPL-H and SMPL-X (Pavlakos et al. 2019)."""

POSE_WIDTHS = {72: "SMPL", 156: "SMPL-H", 165: "SMPL-X", 66: "SMPL-H or SMPL-X without hands"}

MAX_BYTES = 2 * 2**30
"""No clip unpacks to more; a small npz may claim to."""

MAX_DISTANCE = 1e7
"""Metres from the origin: more than any map's coordinates, and little enough for second differences."""

MAX_TURN = 1e4
"""Radians of one rotation vector: over a thousand whole turns."""


def read_amass(
    path: Path,
    rate: float | None = None,
    up: Up | None = None,
    ups: Ups = BY_ITSELF,
    person: int | None = None,
) -> Motion:
    """Read an AMASS-style npz or a `.smpl` file, with the labels of `Motion.save` if it holds them.

    AMASS files (Mahmood et al. 2019) hold ``poses`` (T, 72, 156 or 165) as axis-angle, or ``root_orient`` and
    ``pose_body``, ``trans`` (T, 3) in metres and ``mocap_framerate``. Their world is z up, that of `.smpl`
    files y up. `rate` and the axis `up` take precedence over the file's own; `ups` are the axes of its
    library. Of several people in a result the `person` is taken, 1 being the one seen longest.

    Raises UnusableMotion if it is no such file, or holds a pose instead of a motion.
    """
    size_and_head(path)
    with reading(ValueError):
        return _labelled(path, rate, up, ups, person)


def _labelled(path: Path, rate: float | None, up: Up | None, ups: Ups, person: int | None) -> Motion:
    """The motion that `read_amass` reads."""
    arrays, people = _read_arrays(path, person)
    motion = replace(_motion_of(arrays, rate, up, ups), people=people)
    labels = [str(arrays[name]) for name in LABELS if name in arrays]
    return motion.labelled(*labels) if len(labels) == len(LABELS) else motion


def smpl_motion(poses: np.ndarray, trans: np.ndarray, rate: float, up: Up | None = None) -> Motion:
    """The motion of SMPL parameters in memory, as `read_amass` reads them from a file.

    Raises UnusableMotion if they are no motion; the message says why.
    """
    rate = usable_rate(rate, rate)
    with reading(ValueError):
        return _motion_of({"poses": poses, "trans": trans}, rate, up, BY_ITSELF)


def _motion_of(arrays: dict[str, np.ndarray], rate: float | None, up: Up | None, ups: Ups) -> Motion:
    """The motion, with the file's axis that is up turned to z."""
    poses = _poses(arrays)
    refuse_too_long(len(poses), poses.shape[1] // 3)
    refuse_few_frames(len(poses))
    trans, rate = _trans(arrays), _rate(arrays, rate)
    if len(poses) != len(trans):
        raise UnusableMotion(f"its 'poses' have {len(poses)} frames but its 'trans' has {len(trans)}")
    _refuse_beyond(poses, "poses", MAX_TURN, "rad", "in radians")
    refuse_degrees(poses)
    _refuse_beyond(trans, "trans", MAX_DISTANCE, "m", "in metres")
    rotations = np.tile(np.eye(3), (len(poses), N_JOINTS, 1, 1))
    turns = Rotation.from_rotvec(poses.reshape(-1, 3)).as_matrix().reshape(len(poses), -1, 3, 3)
    rotations[:, 1:BODY_JOINTS] = in_axes(turns[:, 1:], Y_UP_TO_Z_UP.T)
    rotations[:, 0], pelvis = turns[:, 0] @ Y_UP_TO_Z_UP.T, trans + SMPL_PELVIS
    up, guess = (up, "") if up else _up(arrays, rotations, pelvis, ups)
    rotations[:, 0] = turned(rotations[:, 0], up)
    return Motion(rotations, turned(pelvis.T, up).T, rate, up_guessed=guess)


def _up(arrays: dict[str, np.ndarray], rotations: np.ndarray, pelvis: np.ndarray, ups: Ups) -> tuple[Up, str]:
    """The axis of the file that is up: by its format, or by its library or its people, and then twice."""
    if arrays.keys() >= set(LABELS):
        return "z", ""
    if "bodyPose" in arrays:
        return "y", ""

    def look() -> Sight:
        frames = np.linspace(0, len(pelvis) - 1, min(SEEN_FRAMES, len(pelvis))).astype(int)
        _, joints = posed_joints(_rest_joints(), rotations[frames], pelvis[frames])
        return Sight.of_body(joints, range(N_JOINTS))

    return ups.with_guess(AMASS if "global_orient" not in arrays else SMPLX, look)


@cache
def _rest_joints() -> np.ndarray:
    """The bundled body's joints in its rest pose, (24, 3)."""
    return Body.bundled().joints


def _read_arrays(path: Path, person: int | None) -> tuple[dict[str, np.ndarray], int]:
    """The small arrays of an npz or of a result's person, and how many people it shows.

    Object arrays and unreasonable sizes are refused.
    """
    poses = [name for names in POSE_KEYS for name in names]
    names = (*poses, *TRANS_KEYS, *RESULT_KEYS, *RATE_KEYS, *LABELS)
    is_json = path.suffix.lower() == ".json"
    is_result = is_json or path.suffix.lower() in RESULT_SUFFIXES
    check = partial(refuse_long_array, most_bones=BODY_JOINTS)
    if is_result:
        people = people_in_result(read_json(path) if is_json else read_result(path))
    elif is_motion_x(path):
        numbers = read_npy(path)
        people = [{name: numbers[:, places] for name, places in MOTION_X.items()}]
    else:
        people = [read_arrays(path, names, MAX_BYTES, check)]
    content = chosen_person(people, person)
    arrays = in_smplx_form({name: content[name] for name in names if name in content})
    if not any(arrays.keys() >= set(names) for names in POSE_KEYS):
        held = ", ".join(sorted(content if is_result else array_names(path))[:8])
        raise UnusableMotion(f"it is not an AMASS-style motion: it holds {held} and no 'poses'")
    return arrays, len(people)


def _poses(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Rotation vectors of the joints before the hands, shape (T, 66)."""
    names = next(names for names in POSE_KEYS if arrays.keys() >= set(names))
    name, poses = "' and '".join(names), arrays[names[0]]
    if len(names) > 1:
        turns = [arrays[part].reshape(len(arrays[part]), -1) for part in names if arrays[part].ndim]
        if len({len(turn) for turn in turns}) != 1 or len(turns) < len(names):
            raise UnusableMotion(f"its '{name}' differ in their number of frames")
        poses = np.concatenate(turns, axis=1)
    if poses.ndim == 3 and poses.shape[2] == 3:
        poses = poses.reshape(len(poses), -1)
    if poses.ndim != 2 or poses.shape[1] not in POSE_WIDTHS or poses.dtype.kind != "f":
        widths = ", ".join(f"{width} ({kind})" for width, kind in POSE_WIDTHS.items())
        hint = ", which look like quaternions" if poses.ndim == 3 and poses.shape[2] == 4 else ""
        raise UnusableMotion(
            f"its '{name}' have shape {poses.shape}{hint}; expected axis-angle (frames, n), n one of {widths}"
        )
    return poses[:, : 3 * BODY_JOINTS].astype(np.float64)


def _trans(arrays: dict[str, np.ndarray]) -> np.ndarray:
    trans = next((arrays[name] for name in TRANS_KEYS if name in arrays), None)
    if trans is None or trans.ndim != 2 or trans.shape[1] != 3 or trans.dtype.kind != "f":
        problem = "is missing" if trans is None else f"has shape {trans.shape}"
        raise UnusableMotion(f"its 'trans' {problem}; expected (frames, 3) in metres")
    return trans.astype(np.float64)


def _rate(arrays: dict[str, np.ndarray], given: float | None) -> float:
    if given is not None:
        return usable_rate(given, given)
    for name in RATE_KEYS:
        if name in arrays and arrays[name].size == 1 and arrays[name].dtype.kind in "fiu":
            rate = float(arrays[name].item())
            if 0 < rate < np.inf:
                own = arrays.keys() >= set(LABELS)  # W2W wrote the rate that it was given
                return usable_rate(rate, rate if own else None)
    raise UnusableMotion(
        f"it does not say its frame rate: none of {', '.join(RATE_KEYS)} holds one; "
        f"give {SAY_RATE}, or save it again with '{RATE_KEYS[0]}'"
    )


def _refuse_beyond(values: np.ndarray, name: str, most: float, unit: str, expected: str) -> None:
    if not np.isfinite(values).all():
        raise UnusableMotion(f"its '{name}' hold values that are not finite (NaN or infinite)")
    largest = np.abs(values).max(initial=0.0)
    if largest > most:
        raise UnusableMotion(
            f"its '{name}' reach {largest:.3g} {unit}, which no body does: it is damaged, or not {expected}"
        )


ORDER = 3
"""Order of the Butterworth filter, which runs forwards and backwards."""


def smoothed_root(motion: Motion, cutoff_hz: float) -> Motion:
    """The same motion with its root path low-passed, without delay; turns of the joints stay as they are.

    Suits inertial motion capture (Xsens, Perception Neuron, Rokoko). Its suits measure how segments turn, not
    where the body is: the root hangs on the foot that seems to stand and jumps by millimetres when the
    other takes over, which differentiating twice makes the largest acceleration of all. Optical motion
    capture measures the root; leave it alone.

    The cut-off (-3 dB) lies between 0 and half the frame rate, or a ValueError is raised.
    """
    return replace(motion, pelvis=low_passed(motion.pelvis, motion.rate, cutoff_hz))


def low_passed(path: np.ndarray, rate: float, cutoff_hz: float) -> np.ndarray:
    """A path (T, 3) low-passed without delay, as `smoothed_root` does it."""
    return butterworth(path.T, rate, cutoff_hz, ORDER, zero_phase=True).T


def at_rate(motion: Motion, rate: float) -> Motion:
    """The motion at another frame rate, along splines through its frames that bend smoothly."""
    if motion.rate == rate:
        return motion
    own = np.arange(motion.n_frames) / motion.rate
    times = np.arange(count_resampled(motion.n_frames, motion.rate, rate)) / rate
    times = np.minimum(times, own[-1])  # rounding
    rotations = np.empty((len(times), N_JOINTS, 3, 3))
    for joint in range(N_JOINTS):
        turns = RotationSpline(own, Rotation.from_matrix(motion.rotations[:, joint]))
        rotations[:, joint] = turns(times).as_matrix()
    path = scipy.interpolate.CubicSpline(own, motion.pelvis)
    return replace(motion, rotations=rotations, pelvis=path(times), rate=rate)
