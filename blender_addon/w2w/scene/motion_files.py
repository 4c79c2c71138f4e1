# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with a motion file, told from its bytes, before or after Blender refuses it."""

from __future__ import annotations

import mmap
import re
import struct
from pathlib import Path

from ..core.source_motion import UnusableMotion

FBX_MAGIC = b"Kaydara FBX Binary  \x00\x1a\x00"
GIT_LFS_MAGIC = b"version https://git-lfs"
FBX_HEADER_SIZE = 27
NOT_FINITE = "its animation holds values that no body has (NaN, infinite or beyond 1e10)"
_NOT_FINITE = re.compile(rb"nan|inf|#|e\+?0*[1-9]\d", re.IGNORECASE)
"""As C and Python write such numbers into text."""

BVH_SKELETON_SIZE = 2**20
"""Bytes within which the skeleton of a BVH file ends: hundreds of times what a body takes."""


def check_fbx(path: Path) -> None:
    """Refuse a file that cannot be an FBX, with a sentence that is true.

    Raises
    ------
    UnusableMotion
        If the file is missing, empty, a Git LFS pointer, cut short or no FBX at all.
    """
    size, head = _size_and_head(path)
    if head.startswith(FBX_MAGIC):
        _check_binary_fbx(path, size, head)
    elif b"FBX" not in head and b"FBXHeaderExtension" not in head:
        raise UnusableMotion(
            "it is not an FBX file: it has neither the binary mark nor FBX text at its start"
        )


def check_bvh(path: Path) -> None:
    """Refuse a file that cannot be a BVH, with a sentence that is true.

    Raises
    ------
    UnusableMotion
        If the file is missing, empty, a Git LFS pointer, no BVH, cut short, of unequal braces, or holds
        values that are not finite, which Blender's importer would turn into a pose.
    """
    size, head = _size_and_head(path)
    if b"HIERARCHY" not in head[:200]:
        raise UnusableMotion("it is not a BVH file: it does not begin with HIERARCHY")
    with path.open("rb") as stream:
        skeleton, motion, _ = stream.read(BVH_SKELETON_SIZE).partition(b"MOTION")
    if not motion:
        if size <= BVH_SKELETON_SIZE:
            raise UnusableMotion(f"it is cut short at {size} bytes: no MOTION follows its skeleton")
        return
    opened, closed = skeleton.count(b"{"), skeleton.count(b"}")
    if opened != closed:
        raise UnusableMotion(f"it is damaged: its skeleton opens {opened} braces and closes {closed}")
    offsets = b" ".join(line for line in skeleton.splitlines() if b"OFFSET" in line)
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as whole:
        if _NOT_FINITE.search(offsets) or _NOT_FINITE.search(whole, len(skeleton)):
            raise UnusableMotion(NOT_FINITE)


def _size_and_head(path: Path) -> tuple[int, bytes]:
    try:
        size = path.stat().st_size
        with path.open("rb") as stream:
            head = stream.read(4096)
    except OSError as error:
        raise UnusableMotion(f"it cannot be read: {error.strerror}") from error
    if size == 0:
        raise UnusableMotion("the file is empty (0 bytes)")
    if head.startswith(GIT_LFS_MAGIC):
        raise UnusableMotion("it is a Git LFS pointer, not the motion itself: fetch it with 'git lfs pull'")
    return size, head


def _check_binary_fbx(path: Path, size: int, head: bytes) -> None:
    """Follow the top-level records: each tells where it ends, and the file must reach there."""
    if size <= FBX_HEADER_SIZE:
        raise UnusableMotion(
            f"it is cut short: {size} bytes, which is no more than the header of an FBX file"
        )
    version = struct.unpack_from("<I", head, 23)[0]
    layout = "<Q" if version >= 7500 else "<I"
    position = FBX_HEADER_SIZE
    with path.open("rb") as stream:
        while True:
            stream.seek(position)
            field = stream.read(struct.calcsize(layout))
            if len(field) < struct.calcsize(layout):
                raise UnusableMotion(f"it is cut short at {size} bytes: its list of records has no end")
            end = struct.unpack(layout, field)[0]
            if end == 0:
                return
            if end > size:
                raise UnusableMotion(
                    f"it is cut short: a record should end at byte {end}, the file at {size}"
                )
            if end <= position:
                raise UnusableMotion(
                    f"it is damaged: a record at byte {position} claims to end before it begins"
                )
            position = end
