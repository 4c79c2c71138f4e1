# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command w2w ...`: the whole `w2w` command line, from the installed extension alone."""

import bpy

_registered: list[object] = []


def register() -> None:
    """Tell Blender of the command; nothing of it is imported before it is used."""
    _registered.append(bpy.utils.register_cli_command("w2w", run))


def unregister() -> None:
    """Take it back."""
    while _registered:
        bpy.utils.unregister_cli_command(_registered.pop())


def run(arguments: list[str]) -> int:
    """Run the command line, in a process that does nothing else.

    Returns
    -------
    int
        The exit code.
    """
    from .headless.start import run_arguments

    return run_arguments(arguments)
