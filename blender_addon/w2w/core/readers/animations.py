# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of the animations in a glTF or FBX file, by its bytes: each of several is a clip."""

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from ..motion.source import UnusableMotion
from .import_checks import PLAIN_GLTF, animation_names

MIXAMO = "mixamo.com"
"""The animation that Mixamo writes."""

SAYS_NOTHING = re.compile(
    r"mixamo\.com|(base)? ?layer ?\d*|take ?\d*|scene|animation|anim|action|default|armature", re.IGNORECASE
)
"""Names that programs give to actions by themselves: they label nothing."""

HEAD_BYTES = 2**17
"""Bytes of an FBX file in which its table of contents lies."""

MOST_BYTES = 2**28
"""Bytes of a file in which names are sought."""

SEVERAL = re.compile(
    rb'AnimationStack(?:"\s*\{\s*Count:\s*(?:[2-9]|\d\d)|'
    rb".{12,25}\x05CountI(?:[^\x00\x01]...|.[^\x00]..))",
    re.DOTALL,
)
"""The entry of a table of contents, as text or binary, of two animations or more."""

STACK = re.compile(
    rb'AnimationStack:\s*\d+,\s*"AnimStack::([^"\n]{1,500})"|'
    rb"AnimationStackL.{8}S.{4}([^\x00]{1,500})\x00\x01AnimStack",
    re.DOTALL,
)
"""An animation of an FBX file, with its name."""


def telling_part(name: str, own: frozenset[str] = frozenset()) -> str:
    """The part of an action's name, such as ``Armature|Walk|Layer0``, that says something; "" if none does.

    `own` are further parts that say nothing.
    """
    parts = [re.sub(r"\.\d{3}$", "", part).strip() for part in name.split("|")]
    telling = [part for part in parts if part not in own and not SAYS_NOTHING.fullmatch(part)]
    return telling[-1] if telling else ""


def animations_in(path: Path) -> dict[str, str]:
    """What each animation of a file is called, by a short name; {} unless several have telling names.

    In a file of Mixamo's only its own counts: names of others there may be empty. A file that is damaged has
    none: its reader says what is wrong.
    """
    kind = path.suffix.lower()
    names: list[str] = []
    with suppress(UnusableMotion, OSError, KeyError, TypeError, AttributeError):
        if path.is_file() and (kind == ".fbx" or kind in PLAIN_GLTF):
            names = list(dict.fromkeys(_fbx_stacks(path) if kind == ".fbx" else animation_names(path)))
    is_mixamo = any(MIXAMO in name for name in names)
    names = [name for name in names if telling_part(name)]
    if is_mixamo or len(names) < 2:
        return {}
    short = names
    while all("|" in name for name in short) and len({name.partition("|")[0] for name in short}) == 1:
        short = [name.partition("|")[2] for name in short]
    return dict(zip(short, names, strict=True))


def _fbx_stacks(path: Path) -> Iterator[str]:
    with path.open("rb") as stream:
        head = stream.read(HEAD_BYTES)
        if SEVERAL.match(head, max(0, head.find(b"AnimationStack"))):  # found faster than by the pattern
            stream.seek(0)
            for found in STACK.finditer(stream.read(MOST_BYTES)):
                yield (found[1] or found[2]).decode("utf-8", "replace")


class Content(NamedTuple):
    """A motion in a file: all of it, or one of several animations."""

    path: Path
    file: str  # its path inside the library
    animation: str = ""
    pack: str = ""  # path inside the library of a file with several


def contents(files: Iterable[tuple[Path, str]]) -> list[Content]:
    """The motions in files, which are given with their paths inside a library."""
    found: list[Content] = []
    for path, file in files:
        names = animations_in(path)
        found += [Content(path, f"{file}/{short}", full, file) for short, full in names.items()]
        found += [] if names else [Content(path, file)]
    return found
