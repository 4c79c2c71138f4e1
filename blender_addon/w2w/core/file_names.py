# SPDX-License-Identifier: GPL-3.0-or-later
"""File names as text: any name the system allows can be shown, written down and hashed."""

from __future__ import annotations

import os
from pathlib import PurePath

KEEP = "surrogatepass" if os.name == "nt" else "surrogateescape"
"""How Python keeps what is no Unicode in a file name."""


def name_bytes(name: str | PurePath) -> bytes:
    """A name's bytes, whatever the locale made of them: UTF-8 where it is text at all."""
    return str(name).encode("utf-8", KEEP)


def shown(name: str | PurePath) -> str:
    r"""A name as text that can be printed and written to any file; other bytes as ``\xe9``.

    Examples
    --------
    >>> shown("caf\udce9.fbx")
    'caf\\xe9.fbx'
    """
    return name_bytes(name).decode("utf-8", "backslashreplace")
