# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and sentences, written for people and read from them."""

from __future__ import annotations

from collections.abc import Collection
from itertools import chain, count


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
