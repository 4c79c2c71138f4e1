# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W as a Blender add-on: hands registration on to the user interface."""

from __future__ import annotations

import atexit
import importlib.util
import sys

REQUIRED = ("cmap", "scipy", "sklearn", "threadpoolctl", "trimesh")
"""Packages beyond Blender's own that the extension imports wherever it runs; all of them, and those of the
command line, come with the zip."""


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
            f"W2W lacks the Python packages {', '.join(missing)} for this Blender's Python "
            f"{sys.version_info.major}.{sys.version_info.minor}: install the extension from a zip made with "
            "'make extension', which brings those for Python 3.11 and 3.13, or, for another Python, with "
            "'make extension BLENDER=/path/to/this/blender'"
        )
    from . import command_line, ui

    ui.register()
    command_line.register()
    # Blender's Python module hangs at its exit where classes are still registered
    atexit.register(unregister)


def unregister() -> None:
    """Take back what `register` did."""
    from . import command_line, ui

    atexit.unregister(unregister)
    command_line.unregister()
    ui.unregister()
