# SPDX-License-Identifier: GPL-3.0-or-later
"""The system's libraries that Blender's module opens: which of them this machine lacks.

Runs by itself on a bare Python, before anything is installed: it prints what is missing as LIBRARY=PACKAGE.
"""

from __future__ import annotations

import ctypes
import sys

LIBRARIES = {
    "libX11.so.6": "libx11-6",
    "libXrender.so.1": "libxrender1",
    "libXfixes.so.3": "libxfixes3",
    "libXi.so.6": "libxi6",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libSM.so.6": "libsm6",
    "libICE.so.6": "libice6",
    "libGL.so.1": "libgl1",
}
"""Each library, and the Debian package that brings it with the drivers it needs."""


def missing_libraries() -> list[str]:
    """The libraries that cannot be loaded here, by the names Blender's module asks for (Linux only)."""
    return [name for name in LIBRARIES if not _loads(name)] if sys.platform == "linux" else []


def how_to_install(libraries: list[str]) -> str:
    """The line to run on Debian and Ubuntu for some of `LIBRARIES`."""
    return f"sudo apt-get install -y {' '.join(LIBRARIES[name] for name in libraries)}"


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


if __name__ == "__main__":
    print(*(f"{name}={LIBRARIES[name]}" for name in missing_libraries()))
