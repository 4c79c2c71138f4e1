# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line at work for the panel, in a process of its own: it writes what it always writes."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Generator, Sequence
from pathlib import Path

import bpy

from .jobs import Step
from .preferences import EXTENSION

ROOT = Path(__file__).resolve().parents[4]
POLL = 0.02
"""Seconds between two looks at the process."""


def command(arguments: Sequence[str]) -> list[str]:
    """How to start `w2w` here: by the Blender program with this extension, or by Python."""
    if bpy.app.binary_path:
        blender = [bpy.app.binary_path, "--background", "--addons", EXTENSION]
        return [*blender, "--command", "w2w", *arguments]
    return [sys.executable, "-m", "headless", *arguments]


def run_headless(arguments: Sequence[str], text: str, low: float, high: float) -> Generator[Step, None, None]:
    """Run a command of `w2w` as steps of a job; it ends with the job.

    Raises
    ------
    ValueError
        If the command fails; with what it said.
    """
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command(arguments), cwd=ROOT, stdout=said, stderr=subprocess.STDOUT)
        try:
            while process.poll() is None:
                time.sleep(POLL)
                yield Step((low + high) / 2, text)
        finally:
            if process.poll() is None:
                process.kill()
            process.wait()
        said.seek(0)
        words = " ".join(said.read().decode("utf-8", "replace").split())
    if process.returncode:
        raise ValueError(f"w2w {arguments[0]} failed: {words[-300:] or process.returncode}")
