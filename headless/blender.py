# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender in this process: the `bpy` module or the program, and where the program finds W2W's libraries."""

from __future__ import annotations

import shlex
import sys
from importlib.machinery import PathFinder
from pathlib import Path

import w2w


def inside_blender() -> bool:
    """Whether this is the Blender program, whose Python cannot start workers with `bpy`."""
    return bool(sys.modules.get("bpy")) and bool(sys.modules["bpy"].app.binary_path)


def forget_scripts_path() -> None:
    """Let a fresh worker find the `bpy` module.

    Importing `bpy` puts Blender's scripts folder on the path, with a package `bpy` in it that
    needs the module loaded first; workers inherit the path but not the module.
    """
    if "bpy" not in sys.modules:
        sys.path[:] = [entry for entry in sys.path if not _is_scripts_folder(Path(entry))]


def _is_scripts_folder(folder: Path) -> bool:
    return folder.parts[-2:] == ("scripts", "modules") and (folder / "bpy" / "__init__.py").is_file()


ROOT = Path(__file__).resolve().parents[1]


def find_libraries() -> None:
    """Put W2W's libraries on the path where they are not: the extension's, or those that `make setup` made.

    Raises
    ------
    SystemExit
        If there are none for this Python; the sentence says how to get them.
    """
    if not (missing := w2w.missing_libraries()):
        return
    for folder in _library_folders():
        if all(PathFinder.find_spec(name, [str(folder)]) for name in missing):
            sys.path.append(str(folder))  # last, so that Blender's own numpy stays
            return
    raise SystemExit(_how_to_get_libraries(missing))


def _library_folders() -> list[Path]:
    """Where libraries for this Python may be, best first."""
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    folders = [
        ROOT / ".venv" / "lib" / f"python{version}" / "site-packages",
        ROOT / f".venv-blender-python{version}",
    ]
    if "bpy" in sys.modules:
        extensions = sys.modules["bpy"].utils.user_resource("EXTENSIONS")
        folders.insert(0, Path(extensions) / ".local" / "lib" / f"python{version}" / "site-packages")
    return folders


def _program() -> str:
    """The Blender program that this is, if it is one."""
    return sys.modules["bpy"].app.binary_path if "bpy" in sys.modules else ""


def _how_to_get_libraries(missing: list[str]) -> str:
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    program = _program()
    if not (ROOT / "Makefile").exists():  # an installed extension
        return (
            f"W2W lacks the Python packages {', '.join(missing)}: install the extension from a zip that was "
            f"made for Python {version}"
        )
    if not program:
        return f"W2W's libraries are not there for Python {version}: run 'make setup' in {ROOT}"
    return (
        f"W2W's libraries are not there for this Blender's Python {version}. Get them once, with\n"
        f"    make -C {shlex.quote(str(ROOT))} setup BLENDER={shlex.quote(program)}\n"
        "or install W2W's extension in this Blender"
    )
