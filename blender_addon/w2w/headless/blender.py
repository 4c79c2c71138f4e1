# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender in this process, module or program: whether it is installed, and where W2W's libraries are."""

import shlex
import site
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import PathFinder
from importlib.util import find_spec
from pathlib import Path

from .system_libraries import missing_library

ROOT = Path(__file__).resolve().parents[3]

LIBRARIES = (
    "PIL", "filelock", "jinja2", "loky", "matplotlib", "numpy", "plyfile", "rich", "scipy", "threadpoolctl",
    "trimesh", "typer",
)  # fmt: skip
"""Import names of the libraries bundled with the extension; a test keeps the list in step."""

NONE_FOR_THIS = "" if sys.version_info[:2] in ((3, 11), (3, 13)) else ", for there is none for this Python"
NOT_INSTALLED = (
    f"Blender's Python module, bpy, is not installed{NONE_FOR_THIS}. In W2W's folder run 'make setup', which "
    "makes .venv, or, in an environment of your own (Python 3.11 or 3.13): pip install '.[blender]'"
)


class NoBlenderError(Exception):
    """Blender's module cannot be imported; the message says why and what to do."""


def check_installed() -> None:
    """Raise a NoBlenderError, before any work, where Blender's module is not even there."""
    if "bpy" not in sys.modules and find_spec("bpy") is None:
        raise NoBlenderError(NOT_INSTALLED)


@contextmanager
def needs_blender() -> Iterator[None]:
    """Raise a NoBlenderError if an import in the block lacks `bpy` or a system library that it opens."""
    try:
        yield
    except ImportError as error:
        if isinstance(error, ModuleNotFoundError) and error.name in ("bpy", "mathutils"):
            raise NoBlenderError(NOT_INSTALLED) from error
        if sentence := missing_library(str(error)):
            raise NoBlenderError(f"Blender's Python module, bpy, cannot be loaded: {sentence}") from error
        raise


def inside_blender() -> bool:
    """Whether this is the Blender program, whose Python cannot start workers with `bpy`."""
    return bool(_program())


def _program() -> str:
    """The path of this Blender program, or "" in any other Python."""
    return sys.modules["bpy"].app.binary_path if sys.modules.get("bpy") else ""


def find_libraries() -> None:
    """Let a Blender without W2W's libraries find those of the extension, or of `make setup`.

    Where there are none for this Python, a SystemExit says how to get them.
    """
    if not (missing := [name for name in LIBRARIES if find_spec(name) is None]):
        return
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    packages = Path("lib", f"python{version}", "site-packages")
    folders = [ROOT / ".venv" / packages, ROOT / f".venv-blender-python{version}"]
    if "bpy" in sys.modules:
        folders.insert(0, Path(sys.modules["bpy"].utils.user_resource("EXTENSIONS")) / ".local" / packages)
    for folder in folders:
        if all(PathFinder.find_spec(name, [str(folder)]) for name in missing):
            site.addsitedir(str(folder))  # comes last, so that Blender's own numpy stays
            return
    raise SystemExit(_how_to_get_libraries(missing, version))


def _how_to_get_libraries(missing: list[str], version: str) -> str:
    if not (ROOT / "Makefile").exists():  # an installed extension
        return (
            f"W2W lacks the Python packages {', '.join(missing)}: install the extension from a zip that was "
            f"made for Python {version}"
        )
    if not (program := _program()):
        return f"W2W's libraries are not there for Python {version}: run 'make setup' in {ROOT}"
    return (
        f"W2W's libraries are not there for this Blender's Python {version}. Get them once, with\n"
        f"    make -C {shlex.quote(str(ROOT))} setup BLENDER={shlex.quote(program)}\n"
        "or install W2W's extension in this Blender"
    )
