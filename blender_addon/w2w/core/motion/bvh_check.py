# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with a BVH file, told before Blender's importer guesses a rate or stumbles over a row."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from .motion_file import size_and_head
from .source import HIGHEST_RATE, LOWEST_RATE, NOT_FINITE, UnusableMotion

MOST = 1e10
"""No coordinate or angle of a body comes near."""

SHOWN = 24
"""Characters of a damaged value that are quoted."""

Lines = Iterator[tuple[int, list[str]]]


def check_bvh(path: Path) -> None:
    """Refuse a file that is no whole BVH, with a sentence that is true.

    The file is read once, line by line: its skeleton, the two lines that say how many frames
    there are and how long each takes, and the frames.

    Raises
    ------
    UnusableMotion
        If the file cannot be read, is no BVH, cut short or damaged, if its header and its frames
        disagree, or if it does not say its frame rate, which Blender would then make up.
    """
    size, head = size_and_head(path)
    if head.startswith(b"\xef\xbb\xbf"):
        raise UnusableMotion(
            "it begins with a byte order mark, which Blender's importer does not read: save it as UTF-8 "
            "without one"
        )
    if head.lstrip()[:9].upper() != b"HIERARCHY":
        raise UnusableMotion("it is not a BVH file: it does not begin with HIERARCHY")
    try:
        with path.open(encoding="utf-8") as stream:
            lines = ((number, line.split()) for number, line in enumerate(stream, start=1))
            lines = ((number, words) for number, words in lines if words)
            channels = _check_skeleton(lines, size)
            promised = _check_header(lines)
            _check_frames(lines, promised, channels)
    except UnicodeDecodeError as error:
        raise UnusableMotion(
            "it holds bytes that are not UTF-8 text: it is damaged, or was saved in another encoding; if it "
            "opens elsewhere, save it as UTF-8"
        ) from error


def _check_skeleton(lines: Lines, size: int) -> int:
    """Channels of all joints together; the lines are left behind MOTION."""
    opened = closed = channels = 0
    for number, words in lines:
        kind = words[0].upper()
        if kind == "MOTION" and len(words) == 1:
            if opened != closed:
                raise UnusableMotion(f"it is damaged: its skeleton opens {opened} braces and closes {closed}")
            return channels
        opened += sum(word.count("{") for word in words)
        closed += sum(word.count("}") for word in words)
        if kind == "OFFSET":
            _check_numbers(words[1:], number)
        elif kind == "CHANNELS":
            if words[1:2] != [str(len(words) - 2)]:
                raise UnusableMotion(
                    f"it is damaged: line {number} says {_quoted(' '.join(words[1:2]))} channels and "
                    f"names {len(words) - 2}"
                )
            channels += len(words) - 2
    raise UnusableMotion(f"it is cut short at {size} bytes: no MOTION follows its skeleton")


def _check_header(lines: Lines) -> int:
    """The number of frames that the header promises."""
    frames, time = (next(lines, (0, []))[1] for _ in range(2))
    if len(frames) != 2 or frames[0].upper() != "FRAMES:" or not frames[1].isdecimal():
        raise UnusableMotion(f"it does not say how many frames it has: {_instead('Frames: 120', frames)}")
    if len(time) != 3 or [word.upper() for word in time[:2]] != ["FRAME", "TIME:"]:
        raise UnusableMotion(f"it does not say its frame rate: {_instead('Frame Time: 0.0333', time)}")
    try:
        seconds = float(time[2])
    except ValueError:
        seconds = math.nan
    if not (math.isfinite(seconds) and seconds > 0):
        raise UnusableMotion(
            f"its frame time is {_quoted(time[2])}, which gives no frame rate: write the seconds from one "
            "frame to the next, such as 'Frame Time: 0.0333' for 30 frames a second"
        )
    if not LOWEST_RATE <= 1 / seconds <= HIGHEST_RATE:
        raise UnusableMotion(
            f"its frame time of {time[2]} s means {1 / seconds:,.4g} frames a second; motions have "
            f"{LOWEST_RATE:g} to {HIGHEST_RATE:,.0f}: correct its 'Frame Time' line"
        )
    return int(frames[1][:18])  # more digits are no count, and Python refuses thousands of them


def _check_frames(lines: Lines, promised: int, channels: int) -> None:
    found = 0
    for number, words in lines:
        if len(words) != channels:
            raise UnusableMotion(
                f"it is damaged: line {number} holds {len(words)} numbers, and its skeleton has {channels} "
                "channels"
            )
        _check_numbers(words, number)
        found += 1
    if found != promised:
        raise UnusableMotion(
            f"its header promises {promised:,} frame{'s' * (promised != 1)}, and it holds {found:,}: export "
            "it again, or correct its 'Frames' line"
        )


def _check_numbers(words: list[str], number: int) -> None:
    try:
        size = sum(map(abs, map(float, words)))
    except ValueError:
        bad = next(word for word in words if not _is_number(word))
        if any(part in bad.lower() for part in ("nan", "inf", "#")):  # as C writes them
            raise UnusableMotion(NOT_FINITE) from None
        raise UnusableMotion(
            f"it is damaged: line {number} holds {_quoted(bad)} where a number should stand"
        ) from None
    if not size < MOST:  # NaN too
        raise UnusableMotion(NOT_FINITE)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _instead(wanted: str, words: list[str]) -> str:
    found = f"{_quoted(' '.join(words))} stands" if words else "nothing stands"
    return f"{found} where a line such as '{wanted}' belongs"


def _quoted(text: str) -> str:
    """A piece of the file, short and printable."""
    short = text if len(text) <= SHOWN else text[:SHOWN] + "..."
    return f"'{short.encode('unicode_escape').decode('ascii')}'"
