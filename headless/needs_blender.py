# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's module where a command needs it, and a sentence where it cannot be had."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from .system_libraries import LIBRARIES, how_to_install, missing_libraries

NOT_INSTALLED = (
    "Blender's Python module, bpy, is not installed. In W2W's folder run 'make setup', which makes .venv, "
    "or, in an environment of your own (Python 3.11): pip install '.[blender]'"
)

MISSING_LIBRARY = re.compile(r"(\S+\.so[.\d]*): cannot open shared object file")


class NoBlenderError(Exception):
    """Blender's module cannot be imported; the message says why and what to do."""


def check_installed() -> None:
    """Say it before any work where Blender's module is not even there.

    Raises
    ------
    NoBlenderError
    """
    if "bpy" not in sys.modules and find_spec("bpy") is None:
        raise NoBlenderError(NOT_INSTALLED)


@contextmanager
def needs_blender() -> Iterator[None]:
    """Say it in a sentence where an import in the block fails for want of Blender's module.

    Raises
    ------
    NoBlenderError
        If `bpy` is not installed, or a library of the system that it is linked against is missing.
    """
    try:
        yield
    except ImportError as error:
        if isinstance(error, ModuleNotFoundError) and error.name in ("bpy", "mathutils"):
            raise NoBlenderError(NOT_INSTALLED) from error
        if sentence := missing_library(str(error)):
            raise NoBlenderError(f"Blender's Python module, bpy, cannot be loaded: {sentence}") from error
        raise


def missing_library(text: str) -> str:
    """What to do about the library that the dynamic linker says it cannot open; empty where it says none."""
    found = MISSING_LIBRARY.findall(text)
    if not found:
        return ""
    library = found[-1]
    what_to_do = "install the package that brings it"
    if library in LIBRARIES:
        line = how_to_install([library, *(name for name in missing_libraries() if name != library)])
        what_to_do = f"on Debian and Ubuntu run: {line}"
    return f"the system library {library} is missing; {what_to_do}"
