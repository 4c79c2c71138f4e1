# SPDX-License-Identifier: GPL-3.0-or-later
"""One run at a time in an output folder."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout


class FolderBusyError(Exception):
    """Another run works in the folder; the message says which."""


@contextmanager
def only_run(folder: Path) -> Iterator[None]:
    """Hold the folder for this run; the lock goes with the process, however it ends.

    Raises
    ------
    FolderBusyError
        If another run holds it.
    """
    lock, holder = FileLock(folder / "lock"), folder / "holder"
    try:
        lock.acquire(timeout=0)
    except Timeout as error:
        who = holder.read_text() if holder.exists() else "another process"
        raise FolderBusyError(
            f"another run works in {folder.parent} ({who.strip()}): wait for it, or give another --out"
        ) from error
    try:
        holder.write_text(f"process {os.getpid()} on {socket.gethostname()}\n")
        yield
    finally:
        holder.unlink(missing_ok=True)
        lock.release()
