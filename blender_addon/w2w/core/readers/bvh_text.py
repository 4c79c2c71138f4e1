# SPDX-License-Identifier: GPL-3.0-or-later
"""A BVH file's joints, frame rate and numbers, or what is wrong with it."""

import hashlib
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from ..motion.source import (
    MOST,
    MOST_BONE_FRAMES,
    NOT_FINITE,
    UnusableMotion,
    reading,
    refuse_too_long,
    size_and_head,
    usable_rate,
)
from ..wording import count, free_name, restated

SHOWN = 24
"""Characters of a damaged value that are quoted."""

MAX_SKELETON = 1 << 22
"""Characters; a skeleton of a thousand joints has a twentieth."""

HEADER_LINE = 200
"""Characters of a header's line that are looked at."""

CHANNELS = {f"{axis}{kind}" for kind in ("position", "rotation", "scale") for axis in "xyz"}
"""Some programs write scales, and no body has them; they are left out."""

LINES_AT_ONCE = 256
"""Lines of numbers that are read at once, for speed."""

AN_END = -1
"""Stands for an End Site among the numbers of joints."""

Lines = Iterator[tuple[int, str]]


@dataclass
class BvhJoint:
    """A joint of the skeleton."""

    name: str  # words joined by underscores; with a number if it repeats one
    parent: int  # its number; -1 for a root
    line: int  # where it begins
    offset: tuple[float, ...] = ()  # from its parent, of a root from the origin, in the file's unit
    # what its columns are, in their order and in lower case: ``xposition``, ``zrotation``
    channels: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class BvhText:
    """Content of a BVH file."""

    joints: list[BvhJoint]  # B of them, parents before their children
    rate: float  # frames per second
    values: np.ndarray  # (T, C), a row a frame, the joints' channels one after another; angles in degrees


def read_skeleton(path: Path) -> list[BvhJoint]:
    """The skeleton of a BVH file; its frames are not read. Raises UnusableMotion as `read_bvh_text` does."""
    with _opened(path) as (lines, size):
        return _joints(lines, size)


def digest_of(joints: Sequence[BvhJoint]) -> str:
    """A digest of the joints' names, parents and offsets but the roots', which differ from clip to clip."""
    parts = [
        (joint.name, joint.parent, [f"{value + 0.0:.4g}" for value in joint.offset if joint.parent >= 0])
        for joint in joints
    ]
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:16]


def read_bvh_text(path: Path, rate: float | None = None) -> BvhText:
    """Read a BVH file, line by line.

    Raises UnusableMotion if the file cannot be read, is no BVH, cut short or damaged, if its header and its
    frames disagree, if it does not say its frame rate, or is too long.
    """
    with _opened(path) as (lines, size):
        joints = _joints(lines, size)
        n_frames, rate = _header(lines, rate)
        return BvhText(joints, rate, _frames(lines, n_frames, joints))


@contextmanager
def _opened(path: Path) -> Iterator[tuple[Lines, int]]:
    """The numbered lines of a BVH file, and its size in bytes."""
    size, head = size_and_head(path)
    if head.removeprefix(b"\xef\xbb\xbf").lstrip()[:9].upper() != b"HIERARCHY":
        raise UnusableMotion("it is not a BVH file: it does not begin with HIERARCHY")
    other = (
        "it holds bytes that are not UTF-8 text: it is damaged, or was saved in another encoding; if it "
        "opens elsewhere, save it as UTF-8"
    )
    with (
        restated(other, UnicodeDecodeError, UnusableMotion),
        reading(),
        path.open(encoding="utf-8-sig") as stream,
    ):
        yield enumerate(stream, start=1), size


def _joints(lines: Lines, size: int) -> list[BvhJoint]:
    """The skeleton; the lines are left behind MOTION."""
    statements = list(_until_motion(lines, size))
    opened, closed = (sum(words == [brace] for _, words in statements) for brace in "{}")
    if opened != closed:
        raise _damaged(f"its skeleton opens {opened} braces and closes {closed}")
    joints = _tree(statements)
    if not joints:
        raise _damaged("its skeleton has no joint")
    for joint in joints:
        if not joint.offset:
            raise _damaged(f"its joint {_quoted(joint.name)} (line {joint.line}) has no OFFSET")
    return joints


def _until_motion(lines: Lines, size: int) -> Iterator[tuple[int, list[str]]]:
    """Words of each line above MOTION; braces count as lines of their own, which they are in most files."""
    length = 0
    for number, line in lines:
        length += len(line)
        if length > MAX_SKELETON:
            raise _damaged("what should be its skeleton is too large to be one")
        is_one = line.strip() in ("{", "}") or not ("{" in line or "}" in line)
        for part in [line] if is_one else re.split(r"([{}])", line):
            words = part.split()
            if len(words) == 1 and words[0].upper() == "MOTION":
                return
            if words and words[0].upper() != "HIERARCHY":
                yield number, words
    raise UnusableMotion(f"it is cut short at {size} bytes: no MOTION follows its skeleton")


def _tree(statements: list[tuple[int, list[str]]]) -> list[BvhJoint]:
    """The joints of a skeleton's lines; names that come twice get a number, as in Blender."""
    joints: list[BvhJoint] = []
    names: set[str] = set()
    within: list[int] = []  # joints whose braces are open
    named: int | None = None  # whose brace comes next
    for number, words in statements:
        kind = words[0].upper()
        if kind in ("ROOT", "JOINT") and named is None and AN_END not in within[-1:]:
            name, named = free_name("_".join(words[1:]), names, "{}.{:03d}", 1), len(joints)
            names.add(name)
            joints.append(BvhJoint(name, within[-1] if within else -1, number))
        elif kind == "END" and [word.upper() for word in words[1:2]] == ["SITE"] and within:
            named = AN_END
        elif kind == "{" and named is not None:
            within.append(named)
            named = None
        elif kind == "}" and within and named is None:
            within.pop()
        elif kind == "OFFSET" and within:
            offset = _offset(words[1:], number)
            if within[-1] != AN_END:
                joints[within[-1]].offset = offset
        elif kind == "CHANNELS" and within and within[-1] != AN_END:
            _add_channels(joints[within[-1]], words[1:], number)
        else:
            raise _damaged(f"line {number} holds {_quoted(' '.join(words))} where no such line belongs")
    return joints


def _offset(words: list[str], number: int) -> tuple[float, ...]:
    if len(words) != 3:
        raise _damaged(f"line {number} gives an offset of {len(words)} numbers, and one has 3")
    offset = tuple(_numbers(words, number))
    if not all(abs(value) < MOST for value in offset):  # NaN too
        raise UnusableMotion(NOT_FINITE)
    return offset


def _add_channels(joint: BvhJoint, words: list[str], number: int) -> None:
    if words[:1] != [str(len(words) - 1)]:
        named = max(0, len(words) - 1)
        raise _damaged(f"line {number} says {_quoted(' '.join(words[:1]))} channels and names {named}")
    for word in words[1:]:
        channel = word.lower()
        if channel not in CHANNELS or channel in joint.channels:
            twice = " a second time" if channel in joint.channels else ""
            what = f"{_quoted(word)}{twice}"
            raise _damaged(f"line {number} names the channel {what}, not one such as Xposition or Zrotation")
        joint.channels += (channel,)


def _header(lines: Lines, rate: float | None) -> tuple[int, float]:
    """The number of frames that the header promises, and frames per second: `rate` if it is known."""
    full = (words for words in (line[:HEADER_LINE].split() for _, line in lines) if words)
    frames, time = next(full, []), next(full, [])
    if len(frames) != 2 or frames[0].upper() != "FRAMES:" or not frames[1].isdecimal():
        raise UnusableMotion(f"it does not say how many frames it has: {_instead('Frames: 120', frames)}")
    if len(time) != 3 or [word.upper() for word in time[:2]] != ["FRAME", "TIME:"]:
        raise UnusableMotion(f"it does not say its frame rate: {_instead('Frame Time: 0.0333', time)}")
    # more digits are no count, and Python refuses thousands
    return int(frames[1][:18]), rate or _rate(time[2])


def _rate(word: str) -> float:
    """Frames per second, from the seconds of one frame."""
    seconds = math.nan
    with suppress(ValueError):
        seconds = float(word)
    if not 0 < seconds < math.inf:
        raise UnusableMotion(
            f"its frame time is {_quoted(word)}, which gives no frame rate: write the seconds from one "
            "frame to the next, such as 'Frame Time: 0.0333' for 30 frames a second"
        )
    return usable_rate(1 / seconds, said=f"its frame time of {word} s means")


def _frames(lines: Lines, promised: int, joints: list[BvhJoint]) -> np.ndarray:
    """Numbers of the frames, a row each."""
    channels = sum(len(joint.channels) for joint in joints)
    blocks, held = [np.zeros((0, channels))], 0
    full = ((number, line) for number, line in lines if not line.isspace())
    while block := list(islice(full, LINES_AT_ONCE)):
        blocks.append(_rows(block, channels))
        held += len(block)
        if held * len(joints) > MOST_BONE_FRAMES:
            refuse_too_long(max(held, promised), len(joints))
    if held != promised:
        raise UnusableMotion(
            f"its header promises {count('frame', promised)}, and it holds {held:,}: export it again, "
            "or correct its 'Frames' line"
        )
    rows = np.concatenate(blocks)
    if not (np.abs(rows) < MOST).all():
        raise UnusableMotion(NOT_FINITE)
    return rows


def _rows(lines: list[tuple[int, str]], channels: int) -> np.ndarray:
    """Numbers of lines that are not blank, a row each."""
    with suppress(ValueError):
        rows = np.loadtxt([line for _, line in lines], comments=None, ndmin=2)
        if rows.shape[1] == channels:
            return rows
    return np.array([_row(line, number, channels) for number, line in lines])  # says what is wrong and where


def _row(line: str, number: int, channels: int) -> list[float]:
    words = line.split(None, channels)  # at most: a line may be as long as the file
    if len(words) != channels or not channels:
        held = sum(1 for _ in re.finditer(r"\S+", line))
        raise _damaged(f"line {number} holds {held} numbers, and its skeleton has {channels} channels")
    return _numbers(words, number)


def _numbers(words: list[str], line: int) -> list[float]:
    """Numbers of a line's words; the first that is none is refused."""
    numbers = []
    for word in words:
        try:
            numbers.append(float(word))
        except ValueError:
            if any(part in word.lower() for part in ("nan", "inf", "#")):  # as C writes them
                raise UnusableMotion(NOT_FINITE) from None
            raise _damaged(f"line {line} holds {_quoted(word)} where a number should stand") from None
    return numbers


def _instead(wanted: str, words: list[str]) -> str:
    there = f"{_quoted(' '.join(words))} stands" if words else "nothing stands"
    return f"{there} where a line such as '{wanted}' belongs"


def _quoted(text: str) -> str:
    """A piece of the file, short and printable."""
    short = text if len(text) <= SHOWN else text[:SHOWN] + "..."
    return f"'{short.encode('unicode_escape').decode('ascii')}'"


def _damaged(what: str) -> UnusableMotion:
    return UnusableMotion(f"it is damaged: {what}")
