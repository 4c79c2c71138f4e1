# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W as a Blender add-on: hands registration on to the user interface."""

from __future__ import annotations

import atexit
import importlib.util

REQUIRED = ("scipy", "threadpoolctl", "cmap")
"""Packages beyond Blender's own that no part of the extension works without."""


def register() -> None:
    """Register everything with Blender.

    Raises
    ------
    ImportError
        If a required package is missing, as in an extension that was built without its wheels.
    """
    missing = [name for name in REQUIRED if importlib.util.find_spec(name) is None]
    if missing:
        raise ImportError(
            f"W2W lacks the Python packages {', '.join(missing)}: install the extension from a zip made with "
            "'make extension', which brings them along"
        )
    from . import ui

    ui.register()
    # Blender's Python module hangs at its exit where classes are still registered
    atexit.register(unregister)


def unregister() -> None:
    """Take back what `register` did."""
    from . import ui

    atexit.unregister(unregister)
    ui.unregister()
