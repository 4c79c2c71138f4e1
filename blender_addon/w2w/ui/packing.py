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

from ..core.patches.patches import PatchSet
from ..core.ranking.utility import UtilityMap

KEPT = 8
"""Unpacked results kept in memory."""

T = TypeVar("T")


class Savable(Protocol):
    """What has a `save` that writes one file."""

    def save(self, path: str | Path) -> None:
        """Write to a file."""


_unpacked: OrderedDict[str, PatchSet | UtilityMap] = OrderedDict()


def pack(value: Savable) -> tuple[str, str]:
    """A value as text, and the key of its content.

    Returns
    -------
    text : str
        ASCII, compressed.
    key : str
        Equal for equal content.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "value.npz"
        value.save(path)
        content = path.read_bytes()
    key = hashlib.sha256(content).hexdigest()[:24]
    _keep(key, value)
    return base64.b85encode(zlib.compress(content, 6)).decode("ascii"), key


def unpack(key: str, text: Callable[[], str], load: Callable[[io.BytesIO], T]) -> T:
    """The value of a key; its text is asked for only when it is not in memory."""
    if key not in _unpacked:
        _keep(key, load(io.BytesIO(zlib.decompress(base64.b85decode(text())))))
    _unpacked.move_to_end(key)
    return _unpacked[key]


def _keep(key: str, value: PatchSet | UtilityMap) -> None:
    _unpacked[key] = value
    while len(_unpacked) > KEPT:
        _unpacked.popitem(last=False)
