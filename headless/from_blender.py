# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line in the Blender program, and a subcommand's file run by its path."""

from __future__ import annotations

import shlex
import signal
import sys
from importlib.machinery import PathFinder
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

NEEDED = (
    "cmap", "filelock", "jinja2", "joblib", "matplotlib", "rich", "scipy", "sklearn", "threadpoolctl",
    "trimesh", "typer",
)  # fmt: skip
"""What the command line imports and Blender does not bring."""


def run_command(command: str) -> None:
    """Run one subcommand with what stands after ``--``, or after the file's name.

    Raises
    ------
    SystemExit
        With the command's exit code, or a sentence where W2W's libraries are missing.
    """
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    find_libraries()
    _run([command, *arguments], "w2w")


def run_arguments(arguments: list[str]) -> int:
    """Run ``blender --command w2w`` with what stands after it.

    Returns
    -------
    int
        The exit code.
    """
    try:
        find_libraries()
        _run(arguments, "blender --command w2w")
    except SystemExit as ended:
        if not isinstance(ended.code, str):
            return ended.code or 0
        print(ended.code, file=sys.stderr)
        return 1
    return 0


def find_libraries() -> None:
    """Put W2W's libraries on the path where they are not: the extension's, or those that `make setup` made.

    Raises
    ------
    SystemExit
        If there are none for this Python; the sentence says how to get them.
    """
    missing = [name for name in NEEDED if find_spec(name) is None]
    if not missing:
        return
    for folder in _library_folders():
        if all(PathFinder.find_spec(name, [str(folder)]) for name in missing):
            sys.path.append(str(folder))  # last, so that Blender's own numpy stays
            return
    raise SystemExit(_how_to_get_libraries(missing))


def _run(arguments: list[str], program: str) -> None:
    if "bpy" in sys.modules:
        signal.signal(signal.SIGINT, signal.default_int_handler)  # Blender's own would not stop a run
    from headless.__main__ import main

    main(arguments, program)


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
