# SPDX-License-Identifier: GPL-3.0-or-later
"""Run a subcommand's file by its path: in the Blender program, or with a bare Python."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def run_command(command: str) -> None:
    """Run one subcommand with what stands after ``--``, or after the file's name.

    Raises
    ------
    SystemExit
        With the command's exit code, or a sentence where W2W's libraries are missing.
    """
    _find_libraries()
    from headless.__main__ import main

    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    main([command, *arguments])


def _find_libraries() -> None:
    """Blender's own Python lacks most of W2W's libraries; those of `make setup` do, if it is a 3.11 too."""
    if find_spec("typer") is not None:
        return
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    site = ROOT / ".venv" / "lib" / f"python{version}" / "site-packages"
    if not site.is_dir():
        raise SystemExit(
            f"W2W's libraries are not there for this Python {version}: run 'make setup' in {ROOT} first, "
            "and use a Blender whose Python is 3.11 (4.2 to 5.0)"
        )
    sys.path.append(str(site))  # last, so that Blender's own numpy stays
