# SPDX-License-Identifier: GPL-3.0-or-later
"""A temporary folder of this process, its workers and Blender, of which nothing stays behind.

It stands in a folder of the user's in the system's temporary folder. A lock beside it is held by the
process for as long as it lives: folders whose lock nobody holds are what a killed process left.
"""

from __future__ import annotations

import atexit
import os
import shutil
import stat
import sys
import tempfile
from pathlib import Path

from filelock import FileLock, Timeout

from .stopping import always_when_stopped

VARIABLES = ("TMPDIR", "TEMP", "TMP")
"""Where Python and Blender look."""

_HELD: list[FileLock] = []


def use_own_temporary_folder() -> None:
    """Make a temporary folder, and have this process and its children use it; remove those of dead processes.

    Where none can be made, everything stays as it is.
    """
    if _HELD:
        return
    try:
        home = _home()
        with FileLock(home / "lock", timeout=10):
            _remove_abandoned(home)
            folder = Path(tempfile.mkdtemp(prefix="run-", dir=home))
            lock = FileLock(_lock_of(folder))
            lock.acquire(timeout=0)
    except (OSError, Timeout):
        return
    _HELD.append(lock)
    os.environ.update(dict.fromkeys(VARIABLES, str(folder)))
    tempfile.tempdir = str(folder)

    def remove() -> None:
        shutil.rmtree(folder, ignore_errors=True)
        _lock_of(folder).unlink(missing_ok=True)

    atexit.register(remove)
    always_when_stopped(remove)
    always_when_stopped(_remove_blenders)


def _home() -> Path:
    """The user's own folder, which nobody else can have put there.

    Raises
    ------
    OSError
        If somebody has.
    """
    user = os.getuid() if hasattr(os, "getuid") else None
    home = Path(tempfile.gettempdir()) / (f"w2w-{user}" if user is not None else "w2w")
    home.mkdir(mode=0o700, exist_ok=True)
    found = home.lstat()
    if not stat.S_ISDIR(found.st_mode) or (user is not None and found.st_uid != user):
        raise OSError(f"{home} is not a folder of this user's")
    return home


def _remove_abandoned(home: Path) -> None:
    for folder in home.glob("run-*"):
        if not folder.is_dir():
            continue
        lock = FileLock(_lock_of(folder))
        try:
            with lock.acquire(timeout=0):
                shutil.rmtree(folder, ignore_errors=True)
        except Timeout:
            continue
        _lock_of(folder).unlink(missing_ok=True)


def _lock_of(folder: Path) -> Path:
    return folder.with_name(f"{folder.name}.lock")


def _remove_blenders() -> None:
    """The Blender program made its own before it started W2W."""
    if "bpy" in sys.modules:
        folder = Path(sys.modules["bpy"].app.tempdir)
        if folder.name.startswith("blender_"):
            shutil.rmtree(folder, ignore_errors=True)
