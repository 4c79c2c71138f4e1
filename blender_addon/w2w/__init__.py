# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W, "Where to Wear": where on the body a motion sensor recognises activities best.

One package for two uses. Blender calls `register` and `unregister`; everyone else writes::

    import w2w

    motions = w2w.load("MY_CLIPS")
    patches = w2w.sample_patches(w2w.Body.bundled())
    signals = w2w.synthesize(motions, patches, sensor="bmi270")
    ranking = w2w.rank(signals)
    ranking.best, ranking.wear_together(0.9), ranking.heatmap("best.png")

Names are imported when first used, so that Blender starts no slower for them.
"""

import ast
import atexit
import importlib
from pathlib import Path
from typing import Any

__version__ = "0.1.0"
"""The one place where it is written for pip; a test holds the other files to it."""

_STUB = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
_HOMES = {
    each.name: line.module for line in _STUB.body if isinstance(line, ast.ImportFrom) for each in line.names
}
"""Public names with their modules inside this package, as type checkers see them, too."""

__all__ = [*sorted(_HOMES), "__version__"]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__} - {"register", "unregister"})  # those are Blender's


def register() -> None:
    """Register everything with Blender."""
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
