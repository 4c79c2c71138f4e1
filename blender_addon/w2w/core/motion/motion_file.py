# SPDX-License-Identifier: GPL-3.0-or-later
"""Open only regular files of a reasonable size as motion files, nothing that never ends."""

from __future__ import annotations

import errno
import stat
from pathlib import Path

from ..file_names import shown
from .source import UnusableMotion

MAX_FILE_BYTES = 2 * 2**30
"""Far above any clip; a file may claim any size without taking a byte of disk."""

GIT_LFS_MAGIC = b"version https://git-lfs"
HEAD_BYTES = 4096

KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def readable_size(path: Path) -> int:
    """Size of a file that can be read to its end, in bytes; links are followed.

    Raises UnusableMotion if it is missing, a link that leads nowhere, no regular file, or too large.
    """
    try:
        found = path.stat()
    except (OSError, ValueError) as error:
        raise UnusableMotion(_why_missing(path, error)) from error
    kind = stat.S_IFMT(found.st_mode)
    if kind != stat.S_IFREG:
        linked = "it is a link to" if path.is_symlink() else "it is"
        raise UnusableMotion(f"{linked} {KINDS.get(kind, 'something else')}, not a file")
    if found.st_size > MAX_FILE_BYTES:
        raise UnusableMotion(
            f"it is {found.st_size / 2**30:,.1f} GiB large; a motion file may have "
            f"{MAX_FILE_BYTES // 2**30} GiB at most: cut it into parts"
        )
    return found.st_size


def size_and_head(path: Path) -> tuple[int, bytes]:
    """Size and first bytes of a motion file.

    Raises UnusableMotion if it cannot be read, is empty, or is a pointer to a file that was never fetched.
    """
    size = readable_size(path)
    try:
        with path.open("rb") as stream:
            head = stream.read(HEAD_BYTES)
    except OSError as error:
        raise UnusableMotion(unreadable(error)) from error
    if size == 0:
        raise UnusableMotion("the file is empty (0 bytes)")
    if head.startswith(GIT_LFS_MAGIC):
        raise UnusableMotion("it is a Git LFS pointer, not the motion itself: fetch it with 'git lfs pull'")
    return size, head


def unreadable(error: OSError) -> str:
    """The system's reason against reading a file."""
    return f"it cannot be read: {error.strerror or type(error).__name__}"


def _why_missing(path: Path, error: Exception) -> str:
    if not isinstance(error, OSError):  # a name with a zero byte
        return "it cannot be read: there can be no file of this name"
    if error.errno == errno.ELOOP:
        return "it is a symbolic link that leads back to itself"
    if error.errno != errno.ENOENT or not path.is_symlink():
        return unreadable(error)
    target = shown(path.readlink())
    if "annex/objects/" in target.replace("\\", "/"):
        return "it is a git-annex link whose content is not here: fetch it with 'git annex get'"
    return f"it is a link to a file that does not exist: {target}"
