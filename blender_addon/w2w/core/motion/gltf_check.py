# SPDX-License-Identifier: GPL-3.0-or-later
"""What a glTF file must be before Blender's importer sees it: whole, of version 2, and in one file."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

from .motion_file import size_and_head, unreadable
from .source import UnusableMotion

MAGIC = b"glTF"
JSON_CHUNK = 0x4E4F534A
MAX_JSON_BYTES = 256 * 2**20


def check_gltf(path: Path, skin: bool = True) -> None:
    """Refuse a glTF file that is damaged, moves nothing, or reads other files.

    Parameters
    ----------
    path : Path
    skin : bool
        Whether it must have one.

    Raises
    ------
    UnusableMotion
        The message says why.
    """
    size, head = size_and_head(path)
    try:
        content = json.loads(_json_of(path, size, head))
    except OSError as error:
        raise UnusableMotion(unreadable(error)) from error
    except (ValueError, RecursionError) as error:
        raise UnusableMotion(f"it is damaged or no glTF file: {error}") from error
    if not isinstance(content, dict) or not isinstance(content.get("asset"), dict):
        raise UnusableMotion("it is damaged or no glTF file: it names no asset")
    version = str(content["asset"].get("version", ""))
    if not version.startswith("2"):
        raise UnusableMotion(f"it is glTF of version {version[:20] or 'unknown'}; Blender reads version 2")
    for kind in ("buffers", "images"):
        for item in _items(content, kind):
            if not str(item.get("uri", "data:")).startswith("data:"):
                raise UnusableMotion(f"its {kind} lie in other files: save it as one file, .glb")
    if not _items(content, "animations"):
        raise UnusableMotion("it holds no animation")
    if skin and not _items(content, "skins"):
        raise UnusableMotion("it holds no skeleton (skin)")


def _items(content: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    found = content.get(kind, [])
    if not (isinstance(found, list) and all(isinstance(item, dict) for item in found)):
        raise UnusableMotion(f"it is damaged: its {kind} are no list")
    return found


def _json_of(path: Path, size: int, head: bytes) -> bytes:
    """The JSON of a .gltf, or of the first chunk of a .glb."""
    if not head.startswith(MAGIC):
        if path.suffix.lower() != ".gltf":
            raise ValueError("it does not begin as one")
        if size > MAX_JSON_BYTES:
            raise ValueError("it is too large")
        return path.read_bytes()
    if len(head) < 20:
        raise ValueError("it ends in its header")
    version, length, chunk, kind = struct.unpack_from("<IIII", head, 4)
    if version != 2:
        raise UnusableMotion(f"it is glTF of version {version}; Blender reads version 2")
    if length > size or kind != JSON_CHUNK or chunk > min(size - 20, MAX_JSON_BYTES):
        raise ValueError(f"it is cut short: it has {size} bytes of {length}")
    with path.open("rb") as stream:
        stream.seek(20)
        return stream.read(chunk)
