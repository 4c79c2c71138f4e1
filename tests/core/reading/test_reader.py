# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that kill, outlast or overfill their reader: a sentence, and the next one is read."""

import ctypes
import itertools
import os
import time
import zipfile
from functools import partial

import pytest

from w2w.core.motion.source import UnusableMotion
from w2w.core.reading.reader import HARMLESS_BYTES, Reader, is_harmless

LIMIT_S = 0.5


def reader_of(_path):
    return os.getpid()


def crash(_path):
    ctypes.string_at(0)


def hang(_path):
    ctypes.PyDLL(None).sleep(600)  # keeps the interpreter's lock, as C may


def fill(_path):
    return [bytes(2**26) for _ in itertools.count()]


def missing(path):
    return path.read_bytes()


def faulty(_path):
    raise KeyError("bones")


def read(reader, work, path):
    return reader.read(path, partial(work, path))


@pytest.fixture(scope="module")
def reader():
    with Reader(LIMIT_S, 2**31) as reader:
        yield reader


def risky(tmp_path, name):
    (tmp_path / name).write_bytes(b"C3D")
    return tmp_path / name


@pytest.mark.parametrize(
    ("work", "reason"),
    [
        (crash, r"the program that reads it crashed, or took longer than 0\.5 s or more than 2\.0 GiB"),
        (hang, "the program that reads it crashed, or took longer"),
        (fill, r"it needs more than 2\.0 GiB of memory|the program that reads it crashed"),
        (missing, "it cannot be read: No such file"),
    ],
)
def test_whatever_a_file_does_to_its_reader_is_said_and_the_next_is_read(tmp_path, reader, work, reason):
    path = tmp_path / "bad.c3d"
    with pytest.raises(UnusableMotion, match=reason):
        read(reader, work, path)
    assert read(reader, reader_of, risky(tmp_path, "good.c3d")) != os.getpid()


def test_one_worker_reads_all_files(tmp_path, reader):
    files = [risky(tmp_path, f"{number}.{kind}") for number, kind in enumerate(("c3d", "fbx", "pkl", "GLB"))]
    assert len({read(reader, reader_of, file) for file in files} | {os.getpid()}) == 2


def test_a_file_that_killed_its_reader_is_not_tried_again(tmp_path, reader):
    path = risky(tmp_path, "bad.c3d")
    for work in (crash, reader_of):
        with pytest.raises(UnusableMotion, match="crashed"):
            read(reader, work, path)


def test_a_fault_of_the_reader_comes_back_as_it_is(tmp_path, reader):
    with pytest.raises(KeyError, match="bones"):
        read(reader, faulty, risky(tmp_path, "bad.c3d"))


def test_small_files_that_python_reads_are_read_here(tmp_path, reader):
    (tmp_path / "a.bvh").write_text("HIERARCHY")
    assert read(reader, reader_of, tmp_path / "a.bvh") == os.getpid()
    os.mkfifo(tmp_path / "pipe.bvh")
    assert is_harmless(tmp_path / "pipe.bvh")
    assert is_harmless(tmp_path / "missing.npz")


def test_what_is_large_or_unpacks_to_much_is_not(tmp_path):
    with (tmp_path / "a.bvh").open("wb") as stream:
        stream.truncate(HARMLESS_BYTES + 1)
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("poses.npy", bytes(HARMLESS_BYTES + 1))
    assert (tmp_path / "a.npz").stat().st_size < 2**20
    assert not is_harmless(tmp_path / "a.bvh")
    assert not is_harmless(tmp_path / "a.npz")


def test_the_worker_ends_with_the_block(tmp_path):
    with Reader() as reader:
        pid = read(reader, reader_of, risky(tmp_path, "a.c3d"))
        os.kill(pid, 0)
    time.sleep(0)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
