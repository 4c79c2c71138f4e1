# SPDX-License-Identifier: GPL-3.0-or-later
"""Names, file names and sentences, written for people and read from them."""

import os
import re
import unicodedata
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from html import escape
from itertools import chain, count as numbers_from
from pathlib import PurePath
from typing import Any


def capital(text: object) -> str:
    """A text, such as an error's, with a capital first letter; leaves the rest unchanged."""
    words = str(text)
    return words[:1].upper() + words[1:]


def count(noun: str, number: int) -> str:
    """A number with its noun, in the plural unless there is one.

    Examples
    --------
    >>> count("clip", 1), count("clip", 0), count("activity", 2)
    ('1 clip', '0 clips', '2 activities')
    """
    plural = f"{noun[:-1]}ies" if noun.endswith("y") else f"{noun}s"
    return f"{number:,} {noun if number == 1 else plural}"


Faults = type[BaseException] | tuple[type[BaseException], ...]


@contextmanager
def restated(
    sentence: str | Callable[[Any], str], faults: Faults, kind: Callable[[str], Exception] = ValueError
) -> Iterator[None]:
    """Raise some errors as another, in a sentence, or what a function makes of the error.

    A sentence that ends in a colon goes on with their own words.

    Examples
    --------
    >>> with restated("the rate is no number:", ValueError):
    ...     float("fast")
    Traceback (most recent call last):
    ValueError: the rate is no number: could not convert string to float: 'fast'
    """
    try:
        yield
    except faults as error:
        if callable(sentence):
            raise kind(sentence(error)) from error
        raise kind(f"{sentence} {error}" if sentence.endswith(":") else sentence or str(error)) from error


NAMED = 3
"""Names in a sentence, before it says how many more there are."""


def join_words(words: Sequence[str], most: int = NAMED) -> str:
    """Words as a sentence lists them, the first `most` by name; "" without any.

    Examples
    --------
    >>> join_words(["run", "walk"]), join_words(["bow", "jump", "run", "walk"], most=2)
    ('run and walk', 'bow, jump and 2 more')
    """
    if len(words) > most:
        return f"{', '.join(words[:most])} and {len(words) - most} more"
    return " and ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))


def wrapped(text: str, width: float, measure: Callable[[str], float]) -> list[str]:
    """Lines of a text, none wider than `width` by a measure of lines unless a single word is."""
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and measure(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def cut(text: str, longest: int) -> str:
    """The text without what is beyond so many letters."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def shortened(text: str, width: float, measure: Callable[[str], float]) -> str:
    """The text without its middle if it is wider than `width`: names of clips differ at their ends.

    Examples
    --------
    >>> shortened("dataset-1_bow_active_001", 10, len)
    'dat…ve_001'
    """
    shown, kept = text, len(text) - 1
    while kept > 1 and measure(shown) > width:
        shown, kept = f"{text[: kept // 3]}…{text[kept // 3 - kept :]}", kept - 1
    return shown


INVISIBLE = re.compile("[\u00ad\u200b\u2060\ufeff]")
"""Characters without a width that programs leave in text: soft hyphens, byte order marks and the like."""


def composed(name: str) -> str:
    """A name with each accented letter as one character, where macOS writes two, and no invisible ones."""
    return (name if name.isascii() else unicodedata.normalize("NFC", INVISIBLE.sub("", name))).strip()


def plain_words(name: str) -> str:
    """A name for comparing: case, runs of spaces and how accented letters are encoded do not count.

    Raises ValueError if it is no text.
    """
    if not isinstance(name, str):
        raise ValueError(f"a name is text, such as 'left wrist', not {type(name).__name__}")
    return " ".join(composed(composed(name).casefold()).split())


def free_name(name: str, taken: Collection[str], form: str = "{} {}", first: int = 2) -> str:
    """The name itself if it is free, else with the first free number.

    Examples
    --------
    >>> free_name("ring", {"ring", "ring 2"})
    'ring 3'
    """
    numbered = (form.format(name, number) for number in numbers_from(first))
    return next(free for free in chain([name], numbered) if free not in taken)


KEEP = "surrogatepass" if os.name == "nt" else "surrogateescape"
"""How Python keeps what is no Unicode in a file name."""


def name_bytes(name: str | PurePath) -> bytes:
    """A name's bytes, independent of the locale: UTF-8 if it is text at all."""
    return str(name).encode("utf-8", KEEP)


COMMANDS = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\udc80-\udcff]")
"""Characters that a terminal obeys, such as an escape, or that turn the direction of what follows; and bytes
that are no text."""


def clean(name: str | PurePath) -> str:
    r"""A name as text that can be printed and written to any file; what a terminal would obey as ``%1B``.

    Examples
    --------
    >>> clean("caf\udce9.fbx"), clean("\x1b[2Jwalk")
    ('caf%E9.fbx', '%1B[2Jwalk')
    """
    if (text := str(name)).isascii() and text.isprintable():
        return text  # as nearly all are
    return COMMANDS.sub(_percent, name_bytes(name).decode("utf-8", "surrogateescape"))


def harmless(text: object) -> str:
    """A text of several lines, such as an error's, in which a terminal obeys nothing but the lines' ends."""
    words = str(text)
    return words if words.isascii() and words.isprintable() else COMMANDS.sub(_kept_lines, words)


def _kept_lines(match: re.Match[str]) -> str:
    return match[0] if match[0] in "\n\t" else _percent(match)


def _percent(match: re.Match[str]) -> str:
    return "".join(f"%{byte:02X}" for byte in match[0].encode("utf-8", "surrogateescape"))


class InShort:
    """What displays as a sentence, in a notebook and elsewhere."""

    def in_short(self) -> str:
        """The sentence."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.in_short()}>"

    def _repr_html_(self) -> str:
        return f"<p>{escape(self.in_short())}</p>"


ONLY_ELSEWHERE = re.compile(r",? or (?:Up|Frame Rate) in Blender's import dialog")
OPTION = re.compile(r"--(?:pose-(rate|unit|up|joints)|(person))")


def in_python(text: str, parameter: str = "pose=PoseFacts({}=...)") -> str:
    """A message in the words of Python: an option is the parameter that it stands for.

    Examples
    --------
    >>> in_python("give --pose-rate, or Frame Rate in Blender's import dialog", "{}=...")
    'give rate=...'
    """

    def named(found: re.Match[str]) -> str:
        name = found[1] or found[2]
        return parameter.format({"joints": "joint_set"}.get(name, name))

    return OPTION.sub(named, ONLY_ELSEWHERE.sub("", text))
