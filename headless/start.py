# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the `w2w` command begins: ready for signals before the imports, which take seconds."""

from __future__ import annotations

from .stopping import stop_on_signals


def main() -> None:
    """Run the command line; ends the process with its exit code."""
    stop_on_signals()
    from .__main__ import main as run

    run()
