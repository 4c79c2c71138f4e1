# SPDX-License-Identifier: GPL-3.0-or-later
"""The system's libraries that Blender's module opens: which of them this machine lacks.

Runs by itself on a bare Python, before anything is installed: it prints what is missing as LIBRARY=PACKAGE.
"""

import ctypes
import re
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

UNOPENED = re.compile(r"(?<!\S)(\S+\.so[.\d]*): cannot open shared object file")


def missing_libraries() -> list[str]:
    """The libraries that cannot be loaded here, by the names Blender's module asks for (Linux only)."""
    return [name for name in LIBRARIES if not _loads(name)] if sys.platform == "linux" else []


def how_to_install(libraries: list[str]) -> str:
    """The line to run on Debian and Ubuntu for some of `LIBRARIES`."""
    return f"sudo apt-get install -y {' '.join(LIBRARIES[name] for name in libraries)}"


def missing_library(text: str) -> str:
    """A sentence about the library that the dynamic linker could not open, or "" if the text names none."""
    found = UNOPENED.findall(text)
    if not found:
        return ""
    library = found[-1]
    what_to_do = "install the package that brings it"
    if library in LIBRARIES:
        line = how_to_install([library, *(name for name in missing_libraries() if name != library)])
        what_to_do = f"on Debian and Ubuntu run: {line}"
    return f"the system library {library} is missing; {what_to_do}"


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


if __name__ == "__main__":
    print(*(f"{name}={LIBRARIES[name]}" for name in missing_libraries()))
