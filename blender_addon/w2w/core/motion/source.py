# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion files before retargeting: which can be opened, what they hold, and why some are refused."""

import errno
import json
import math
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..body.body import Y_UP_TO_Z_UP
from ..rotations import cross, dot, length
from ..wording import clean, count, harmless, restated


@dataclass(frozen=True, eq=False)
class SourceMotion:
    """A named skeleton and its motion, in world space: z up, in the file's own unit of length."""

    bones: tuple[str, ...]  # B names as the file has them
    parents: np.ndarray  # (B,), -1 for a root; parents come before their children
    rest: np.ndarray  # (B, 4, 4), world matrix of each bone in the rest pose
    matrices: np.ndarray  # (T, B, 4, 4), world matrix of each bone in each frame
    rate: float  # frames per second
    take: str = ""  # name of the take (action) that the frames come from
    people: int = 1  # whole skeletons in the file, of which this is one
    rest_is_known: bool = True  # whether the file has a rest pose, or `rest` is a frame of the motion
    skeleton: str = ""  # a digest of the bones' names and offsets, of a BVH file
    first_bone: int = 0  # number of the first true bone: 1 if the armature that holds them comes before
    other_takes: tuple[str, ...] = ()  # names of takes of the file that move, too, and are not read
    up: str = ""  # the file's own axis that is up, where it was looked for or given
    up_guessed: str = ""  # the same, if that is assumed
    first_frame: int = 0  # number of the first frame in the file, where those before it are left out
    cut: str = ""  # which frames are left out and why, in words

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.matrices)


def people_in(parents: np.ndarray) -> int:
    """Number of skeletons: bone trees at least half as large as the largest."""
    tree = np.arange(len(parents))
    for bone, parent in enumerate(parents):
        if parent >= 0:
            tree[bone] = tree[parent]
    sizes = np.bincount(tree, minlength=1)
    return max(1, int(np.count_nonzero((sizes > 0) & (2 * sizes >= sizes.max()))))


TO_Z_UP = np.eye(4)
TO_Z_UP[:3, :3] = Y_UP_TO_Z_UP
"""Turns a world whose y axis points up."""

MOST_BONE_FRAMES = 2**24
"""Frames times bones that can be held: 2 GiB of matrices, over an hour of 65 bones at 60 frames/s."""

LOWEST_RATE, HIGHEST_RATE = 1.0, 2000.0
"""Frames per second of motions, from sparse key poses to the fastest motion capture."""

LOWEST_CLAIM = 5.0
"""Fewer frames a second are believed of no file: writers leave a default of 1, and a step takes .5 s."""

SAY_RATE = "--pose-rate, or a column 'rate' in labels.csv"

MIN_FRAMES = 4
"""Fewer frames than a cubic spline needs are a pose, not a motion."""

MOST = 1e10
"""No coordinate, angle or scale of a body comes near, in any unit."""

NOT_FINITE = "its animation holds values that no body has (NaN, infinite or beyond 1e10)"


class UnusableMotion(Exception):  # noqa: N818 - named for what it says, it is shown to people
    """A motion file that cannot be used; the message is the reason, in a sentence for people."""

    def __init__(self, message: object) -> None:
        super().__init__(harmless(message))


def refuse_too_long(n_frames: int, n_bones: int) -> None:
    """Refuse a motion of more than MOST_BONE_FRAMES, which would not fit in memory, before it is read."""
    if n_frames * n_bones > MOST_BONE_FRAMES:
        raise UnusableMotion(
            f"it is too long to be read at once ({n_frames} frames of {n_bones} bones): cut it into parts of "
            f"at most {MOST_BONE_FRAMES // n_bones} frames"
        )


def refuse_long_array(shape: tuple[int, ...], most_bones: int = MOST_BONE_FRAMES) -> None:
    """Refuse an array of three numbers or more a bone and frame by its shape, before it is read.

    Of more than `most_bones` no more are kept.
    """
    if len(shape) > 1:
        refuse_too_long(shape[0], min(most_bones, max(1, math.prod(shape[1:]) // 3)))


def refuse_few_frames(n_frames: int, where: str = "") -> None:
    """Refuse a motion with too few frames to move."""
    if n_frames < MIN_FRAMES:
        raise UnusableMotion(f"it holds a pose, not a motion: {count('frame', n_frames)}{where}")


def reason_of(error: Exception) -> str:
    """Why a file cannot be used, from the error that reading it raised; a fault of W2W is named as one."""
    text = harmless(error).strip()
    if isinstance(error, MemoryError):
        return text or "it needs more memory than there is"
    if text and isinstance(error, (UnusableMotion, ValueError, OSError)):
        return text
    return f"W2W failed on it, please report this: {type(error).__name__}: {text}".rstrip(": ")


def usable_rate(claimed: float, given: float | None = None, said: str = "it says") -> float:
    """The frame rate that the user gave, else the one that a file claims, within the limits of each."""
    rate, lowest = (claimed, LOWEST_CLAIM) if given is None else (given, LOWEST_RATE)
    if not lowest <= rate <= HIGHEST_RATE:
        raise UnusableMotion(
            f"{said} {rate:,.4g} frames a second; motions have {lowest:g} to {HIGHEST_RATE:,.0f}: give the "
            f"true rate ({SAY_RATE})"
        )
    return rate


def refuse_degrees(poses: np.ndarray) -> None:
    """Refuse rotation vectors (T, 3 J) that turn a joint by more than a whole turn in half of the frames."""
    turns = np.linalg.norm(poses.reshape(len(poses), -1, 3)[:, 1:], axis=2).max(axis=1)
    if np.median(turns) > 2 * np.pi:
        raise UnusableMotion(
            f"its 'poses' turn joints by up to {turns.max():.3g} rad, which no body does: they look like "
            "degrees: multiply them by pi / 180"
        )


def unscaled_rotations(matrices: np.ndarray) -> np.ndarray:
    """Rotation part (..., 3, 3) of 4x4 matrices that may also scale.

    Gram-Schmidt on the columns: exact if the scale is uniform, as in FBX and BVH.
    """
    columns = np.empty((3, 3, *matrices.shape[:-2]))  # by component: whole ones are quick to work on
    columns[:2] = np.moveaxis(matrices[..., :3, :2], (-1, -2), (0, 1))
    x, y, z = columns
    y /= np.sqrt(dot(y, y))
    x -= y * dot(x, y)
    x /= np.sqrt(dot(x, x))
    cross(x, y, out=z)
    return np.ascontiguousarray(np.moveaxis(columns, (0, 1), (-1, -2)))


MIN_TURN = np.radians(0.5)
MIN_TRAVEL = 0.005
"""A motion moves if a bone turns by `MIN_TURN` or travels `MIN_TRAVEL` of the skeleton's size."""


def motion_amount(motion: SourceMotion) -> float:
    """How much a motion moves: its widest turn or travel in units of the least that counts."""
    axes = motion.matrices[:, :, :3, 1]
    axes = axes / np.maximum(length(axes)[..., None], 1e-12)
    return _amount(motion.matrices[:, :, :3, 3], axes, motion.rest[:, :3, 3])


def _amount(heads: np.ndarray, axes: np.ndarray, rest: np.ndarray) -> float:
    travel = np.ptp(heads, axis=0).max() / max(np.ptp(rest, axis=0).max(), 1e-12)
    turn = np.linalg.norm(np.ptp(axes, axis=0), axis=-1).max()
    return float(max(travel / MIN_TRAVEL, turn / MIN_TURN))


def refuse_still(heads: np.ndarray, axes: np.ndarray) -> None:
    """Refuse a body whose joints (T, J, 3) do not move and whose axes, of the same shape, do not turn."""
    if _amount(heads, axes, heads[0]) < 1:
        raise UnusableMotion(f"it holds a pose, not a motion: nothing moves over its {len(heads)} frames")


def is_pose(motion: SourceMotion) -> bool:
    """Whether a motion is too short, or moves too little, to be one."""
    return motion.n_frames < MIN_FRAMES or motion_amount(motion) < 1


def refuse_pose(motion: SourceMotion) -> None:
    """Refuse a motion that is too short, in which nothing moves, or with values that no body has."""
    if not np.isfinite(motion.matrices).all():
        raise UnusableMotion(NOT_FINITE)
    refuse_few_frames(motion.n_frames, f" in '{motion.take}'")
    if motion_amount(motion) < 1:
        raise UnusableMotion(
            "it holds a pose, not a motion: "
            f"nothing moves over the {motion.n_frames} frames of '{motion.take}'"
        )


MAX_FILE_BYTES = 2 * 2**30
"""Far above any clip; a file may claim any size without taking a byte of disk."""

GIT_LFS_MAGIC = b"version https://git-lfs"
HEAD_BYTES = 4096

KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def readable_size(path: Path) -> int:
    """Size of a file that can be read to its end, in bytes; links are followed.

    Raises UnusableMotion if it is missing, a link that leads nowhere, no regular file, or too large.
    """
    with restated(partial(_why_missing, path), (OSError, ValueError), UnusableMotion):
        status = path.stat()
    kind = stat.S_IFMT(status.st_mode)
    if kind != stat.S_IFREG:
        linked = "it is a link to" if path.is_symlink() else "it is"
        raise UnusableMotion(f"{linked} {KINDS.get(kind, 'something else')}, not a file")
    if status.st_size > MAX_FILE_BYTES:
        raise UnusableMotion(
            f"it is {status.st_size / 2**30:,.1f} GiB large; a motion file may have "
            f"{MAX_FILE_BYTES // 2**30} GiB at most: cut it into parts"
        )
    return status.st_size


def size_and_head(path: Path) -> tuple[int, bytes]:
    """Size and first bytes of a motion file.

    Raises UnusableMotion if it cannot be read, is empty, or is a pointer to a file that was never fetched.
    """
    size = readable_size(path)
    with reading(), path.open("rb") as stream:
        head = stream.read(HEAD_BYTES)
    if size == 0:
        raise UnusableMotion("the file is empty (0 bytes)")
    if head.startswith(GIT_LFS_MAGIC):
        raise UnusableMotion("it is a Git LFS pointer, not the motion itself: fetch it with 'git lfs pull'")
    return size, head


def unreadable(error: OSError) -> str:
    """The system's reason against reading a file."""
    return f"it cannot be read: {error.strerror or type(error).__name__}"


@contextmanager
def reading(*faults: type[Exception]) -> Iterator[None]:
    """Refuse a file that the system does not let one read, or whose reading raises one of some `faults`."""
    try:
        yield
    except OSError as error:
        raise UnusableMotion(unreadable(error)) from error
    except faults as error:
        raise UnusableMotion(reason_of(error)) from error


def read_json(path: Path) -> Any:
    """The content of a JSON file; UnusableMotion if it is none."""
    with restated("it cannot be read as JSON:", (ValueError, RecursionError), UnusableMotion):
        return json.loads(path.read_text(encoding="utf-8-sig"))


def _why_missing(path: Path, error: Exception) -> str:
    if not isinstance(error, OSError):  # a name with a zero byte
        return "it cannot be read: there can be no file of this name"
    if error.errno == errno.ELOOP:
        return "it is a symbolic link that leads back to itself"
    if error.errno != errno.ENOENT or not path.is_symlink():
        return unreadable(error)
    target = clean(path.readlink())
    if "annex/objects/" in target.replace("\\", "/"):
        return "it is a git-annex link whose content is not here: fetch it with 'git annex get'"
    return f"it is a link to a file that does not exist: {target}"
