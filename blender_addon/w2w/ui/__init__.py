# SPDX-License-Identifier: GPL-3.0-or-later
"""The user interface: what registers with Blender, in the order in which it must."""

from __future__ import annotations


def register() -> None:
    """Register every class, menu entry, tool and handler."""


def unregister() -> None:
    """Take back what `register` did, in reverse order."""
