# SPDX-License-Identifier: GPL-3.0-or-later
"""Names, file names and sentences, written for people and read from them."""

import os
import re
from collections.abc import Collection
from itertools import chain, count
from pathlib import PurePath


def capital(text: object) -> str:
    """A text, such as an error's, with a capital first letter; the rest as it is."""
    words = str(text)
    return words[:1].upper() + words[1:]


def plain_words(name: str) -> str:
    """A name for comparing: case and runs of spaces do not count."""
    return " ".join(name.lower().split())


def free_name(name: str, taken: Collection[str], form: str = "{} {}", first: int = 2) -> str:
    """The name itself where it is free, else with the first free number.

    Examples
    --------
    >>> free_name("ring", {"ring", "ring 2"})
    'ring 3'
    """
    numbered = (form.format(name, number) for number in count(first))
    return next(free for free in chain([name], numbered) if free not in taken)


KEEP = "surrogatepass" if os.name == "nt" else "surrogateescape"
"""How Python keeps what is no Unicode in a file name."""


def name_bytes(name: str | PurePath) -> bytes:
    """A name's bytes, whatever the locale made of them: UTF-8 where it is text at all."""
    return str(name).encode("utf-8", KEEP)


def shown(name: str | PurePath) -> str:
    r"""A name as text that can be printed and written to any file; bytes that are no text as ``%E9``.

    Examples
    --------
    >>> shown("caf\udce9.fbx")
    'caf%E9.fbx'
    """
    if (text := str(name)).isascii():
        return text  # as nearly all are
    text = name_bytes(name).decode("utf-8", "surrogateescape")
    return re.sub("[\udc80-\udcff]", lambda found: f"%{ord(found[0]) - 0xDC00:02X}", text)
