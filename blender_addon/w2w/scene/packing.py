# SPDX-License-Identifier: GPL-3.0-or-later
"""Results packed into the .blend as text, so that a saved file reopens complete on any machine."""

from __future__ import annotations

import base64
import hashlib
import io
import tempfile
import zlib
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Protocol, TypeVar
from weakref import WeakKeyDictionary

from ..core.patches.patches import PatchSet
from ..core.ranking.utility import UtilityMap

KEPT = 8
"""Unpacked results kept in memory."""

MOST_PACKED = 2**30
"""No patches or ranking of ours are npz files of more bytes."""

T = TypeVar("T")


class Savable(Protocol):
    """What has a `save` that writes one file."""

    def save(self, path: str | Path) -> None:
        """Write to a file."""


_unpacked: OrderedDict[str, PatchSet | UtilityMap] = OrderedDict()
_packed: WeakKeyDictionary[Savable, tuple[str, str]] = WeakKeyDictionary()
"""Text and key of values that were packed, or read from a text."""


def pack(value: Savable) -> tuple[str, str]:
    """A value as text, and the key of its content.

    Returns
    -------
    text : str
        ASCII, compressed.
    key : str
        Equal for equal content.
    """
    if value not in _packed:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "value.npz"
            value.save(path)
            content = path.read_bytes()
        text = base64.b64encode(zlib.compress(content, 6)).decode("ascii")
        _packed[value] = (text, _key(content))
        _keep(_key(content), value)
    return _packed[value]


def unpack(key: str, text: Callable[[], str], load: Callable[[io.BytesIO], T]) -> T:
    """The value of a key; its text is asked for only when it is not in memory."""
    if key not in _unpacked:
        _keep(key, load(io.BytesIO(_content(text()))))
    _unpacked.move_to_end(key)
    return _unpacked[key]


def read_packed(text: str, load: Callable[[io.BytesIO], T]) -> T:
    """The value of a text whose key is not known; to `pack` it again is free.

    Raises
    ------
    ValueError
        If the text is damaged.
    """
    content = _content(text)
    key = _key(content)
    value = unpack(key, lambda: text, load)
    _packed[value] = (text, key)
    return value


def _key(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:24]


def _content(text: str) -> bytes:
    """What was packed; a small text may claim to unpack to far more than anything of ours."""
    stream = zlib.decompressobj()
    try:
        content = stream.decompress(base64.b64decode(text), MOST_PACKED)
    except (zlib.error, ValueError) as error:
        raise ValueError("packed results are damaged") from error
    if not stream.eof:
        raise ValueError("packed results are damaged")
    return content


def _keep(key: str, value: PatchSet | UtilityMap) -> None:
    _unpacked[key] = value
    while len(_unpacked) > KEPT:
        _unpacked.popitem(last=False)
