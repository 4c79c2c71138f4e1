# SPDX-License-Identifier: GPL-3.0-or-later
"""A temporary folder of this process, its workers and Blender, of which nothing stays behind.

The process holds a lock in it for as long as it lives. A folder whose lock nobody holds is a killed one's.
"""

from __future__ import annotations

import atexit
import os
import shutil
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

from filelock import FileLock, Timeout

from .stopping import always_when_stopped

PREFIX = "w2w-run-"

_HELD: list[FileLock] = []


def use_own_temporary_folder() -> None:
    """Make a temporary folder for this process and its children, and remove those of killed processes.

    Where none can be made, everything stays as it is.
    """
    if _HELD:
        return
    for other in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError, Timeout):  # its process lives
            _remove_abandoned(other)
    try:
        folder = tempfile.mkdtemp(prefix=PREFIX)
        lock = FileLock(Path(folder, "lock"))
        lock.acquire(timeout=0)
    except (OSError, Timeout):
        return
    _HELD.append(lock)
    os.environ.update(dict.fromkeys(("TMPDIR", "TEMP", "TMP"), folder))  # where Python and Blender look
    tempfile.tempdir = folder

    def remove() -> None:
        lock.release()  # Windows removes no open file
        shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    always_when_stopped(remove)
    always_when_stopped(_remove_blenders)


def _remove_abandoned(folder: Path) -> None:
    """Remove a folder of this user's whose lock nobody holds; one without a lock is just being made."""
    mine = not hasattr(os, "getuid") or folder.lstat().st_uid == os.getuid()
    if mine and (folder / "lock").is_file():
        with FileLock(folder / "lock", timeout=0):
            shutil.rmtree(folder, ignore_errors=True)


def _remove_blenders() -> None:
    """Remove the folder that the Blender program made before it started W2W."""
    if "bpy" in sys.modules:
        folder = Path(sys.modules["bpy"].app.tempdir)
        if folder.name.startswith("blender_"):
            shutil.rmtree(folder, ignore_errors=True)
