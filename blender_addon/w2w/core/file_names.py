# SPDX-License-Identifier: GPL-3.0-or-later
"""File names as text: any name the system allows can be shown, written down and hashed."""

from __future__ import annotations

import os
import re
from pathlib import PurePath

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
    text = name_bytes(name).decode("utf-8", "surrogateescape")
    return re.sub("[\udc80-\udcff]", lambda found: f"%{ord(found[0]) - 0xDC00:02X}", text)
