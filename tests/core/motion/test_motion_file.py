# SPDX-License-Identifier: GPL-3.0-or-later
"""Only regular files of a reasonable size are opened as motions; everything else gets a sentence."""

import os
import socket

import pytest

from w2w.core.motion.motion import read_amass
from w2w.core.motion.source import MAX_FILE_BYTES, UnusableMotion, readable_size, reason_of, size_and_head
from w2w.core.readers.bvh import read_bvh

pytestmark = pytest.mark.skipif(os.name == "nt", reason="Windows has no such files")


def make(path, kind):
    """Something that bears a motion file's name and is none."""
    if kind == "loop":
        path.symlink_to(path.name)
    elif kind == "endless":
        path.symlink_to("/dev/zero")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        here = os.open(path.parent, os.O_RDONLY)
        try:  # by the folder's handle: a socket's whole path may have 107 characters only
            with socket.socket(socket.AF_UNIX) as server:
                server.bind(f"/proc/self/fd/{here}/{path.name}")
        finally:
            os.close(here)
    elif kind == "folder":
        path.mkdir()
    elif kind == "linked pipe":
        os.mkfifo(path.with_suffix(".pipe"))
        path.symlink_to(path.with_suffix(".pipe").name)
    elif kind == "gone":
        path.symlink_to("elsewhere.fbx")
    elif kind == "annex":
        path.symlink_to("../.git/annex/objects/ab/cd/SHA256E-s12--0f/SHA256E-s12--0f")
    elif kind == "huge":
        with path.open("wb") as stream:
            stream.truncate(MAX_FILE_BYTES + 1)


REASONS = {
    "loop": "it is a symbolic link that leads back to itself",
    "endless": "it is a link to a device, not a file",
    "pipe": "it is a named pipe, not a file",
    "socket": "it is a socket, not a file",
    "folder": "it is a folder, not a file",
    "linked pipe": "it is a link to a named pipe, not a file",
    "gone": "it is a link to a file that does not exist: elsewhere.fbx",
    "annex": "it is a git-annex link whose content is not here: fetch it with 'git annex get'",
    "huge": "it is 2.0 GiB large; a motion file may have 2 GiB at most: cut it into parts",
}


@pytest.mark.parametrize("kind", REASONS)
@pytest.mark.parametrize(
    ("read", "suffix"), [(readable_size, ".fbx"), (read_bvh, ".bvh"), (read_amass, ".npz")]
)
def test_what_is_no_file_is_never_opened(tmp_path, kind, read, suffix):
    if kind == "socket" and not os.path.isdir("/proc/self/fd"):  # noqa: PTH112
        pytest.skip("needs /proc")
    path = tmp_path / f"walk{suffix}"
    make(path, kind)
    with pytest.raises(UnusableMotion) as said:
        read(path)
    assert str(said.value) == REASONS[kind]


def test_a_name_that_no_file_can_have(tmp_path):
    with pytest.raises(UnusableMotion, match="there can be no file of this name"):
        readable_size(tmp_path / "a\0b.fbx")


def test_a_link_into_a_content_store_is_a_file(tmp_path):
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "SHA256E-s5--abcdef").write_bytes(b"12345")
    (tmp_path / "walk.fbx").symlink_to("objects/SHA256E-s5--abcdef")
    assert size_and_head(tmp_path / "walk.fbx") == (5, b"12345")


@pytest.mark.parametrize(
    "error", [ValueError(), AssertionError("  "), KeyError(b"Vertices"), AttributeError("no bones")]
)
def test_no_reason_is_empty_or_a_bare_key(error):
    assert reason_of(error).startswith(f"W2W failed on it, please report this: {type(error).__name__}")
    assert reason_of(UnusableMotion("it is cut short")) == "it is cut short"
    assert reason_of(MemoryError()) == "it needs more memory than there is"
