# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches and ranking packed into the .blend as text: a saved file reopens complete on any machine."""

import base64
import hashlib
import io
import tempfile
import zlib
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from ...core.files import most_unpacked
from ...core.patches.patches import PatchSet
from ...core.ranking.utility import UtilityMap
from ...core.wording import restated

KEPT = 8
"""Unpacked results kept in memory."""

MOST_PACKED = 2**30
"""No patches or ranking of ours are npz files of more bytes."""

T = TypeVar("T", PatchSet, UtilityMap)

_unpacked: OrderedDict[str, Any] = OrderedDict()
_packed: WeakKeyDictionary[PatchSet | UtilityMap, tuple[str, str]] = WeakKeyDictionary()
"""Text and key of values that were packed."""


def pack(value: PatchSet | UtilityMap) -> tuple[str, str]:
    """Its file as text, ASCII and compressed, and a key that is equal for equal content."""
    if value not in _packed:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "value.npz"
            value.save(path)
            content = path.read_bytes()
        text, key = base64.b64encode(zlib.compress(content)).decode("ascii"), hashlib.sha256(content)
        _packed[value] = text, key.hexdigest()[:24]
        _keep(_packed[value][1], value)
    return _packed[value]


def unpack(key: str, text: Callable[[], str], load: Callable[[Any], T]) -> T:
    """The value of a key; its text is asked for only when it is not in memory.

    Raises
    ------
    ValueError
        If the text is damaged, or claims to unpack to far more than anything of ours.
    """
    if key not in _unpacked:
        stream = zlib.decompressobj()
        with restated("packed results are damaged", (zlib.error, ValueError)):
            packed = base64.b64decode(text())
            content = stream.decompress(packed, min(MOST_PACKED, most_unpacked(len(packed))))
            if not stream.eof:
                raise ValueError("it ends too early")
        _keep(key, load(io.BytesIO(content)))
    _unpacked.move_to_end(key)
    return _unpacked[key]


def _keep(key: str, value: PatchSet | UtilityMap) -> None:
    _unpacked[key] = value
    while len(_unpacked) > KEPT:
        _unpacked.popitem(last=False)
