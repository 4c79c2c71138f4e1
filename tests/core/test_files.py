# SPDX-License-Identifier: GPL-3.0-or-later
"""Files are written whole or not at all, and the same content gives the same bytes."""

import io
import json
import time
import tracemalloc
import zipfile

import numpy as np
import pytest

from w2w.core.files import (
    PIECE,
    UNPACKED_FREELY,
    atomic_write,
    read_arrays,
    read_npy,
    told_of_writes,
    write_json,
    write_npz,
)


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "result.bin"
    path.write_bytes(b"old")

    def fail():
        with atomic_write(path) as stream:
            stream.write(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert path.read_bytes() == b"old"
    assert [item.name for item in tmp_path.iterdir()] == ["result.bin"]


@pytest.mark.parametrize("compress", [False, True])
def test_npz_bytes_do_not_depend_on_the_time(tmp_path, compress, monkeypatch):
    arrays = {"a": np.arange(5), "name": np.array("walk")}
    write_npz(tmp_path / "1.npz", arrays, compress=compress)
    monkeypatch.setattr(time, "localtime", lambda *_: time.gmtime(1e9))  # as a zip member's time is found
    write_npz(tmp_path / "2.npz", arrays, compress=compress)
    assert (tmp_path / "1.npz").read_bytes() == (tmp_path / "2.npz").read_bytes()
    with np.load(tmp_path / "1.npz", allow_pickle=False) as data:
        np.testing.assert_array_equal(data["a"], arrays["a"])


def test_object_arrays_are_refused(tmp_path):
    with pytest.raises(ValueError, match="Object arrays"):
        write_npz(tmp_path / "bad.npz", {"a": np.array([{}], dtype=object)})
    assert not list(tmp_path.iterdir())


def test_json_refuses_nan(tmp_path):
    with pytest.raises(ValueError, match="JSON"):
        write_json(tmp_path / "bad.json", {"a": float("nan")})
    write_json(tmp_path / "good.json", {"ü": 1})
    assert json.loads((tmp_path / "good.json").read_text(encoding="utf-8")) == {"ü": 1}


def test_an_npy_file_comes_back(tmp_path):
    np.save(tmp_path / "a.npy", np.arange(6).reshape(2, 3))
    np.testing.assert_array_equal(read_npy(tmp_path / "a.npy"), [[0, 1, 2], [3, 4, 5]])


@pytest.mark.parametrize("compress", [False, True])
@pytest.mark.parametrize(
    "array",
    [
        np.array(2.5),
        np.array(["", "Zoë"]),
        np.zeros((0, 3)),
        np.arange(3, dtype=">i4"),
        np.asfortranarray(np.arange(12.0).reshape(3, 4)),
        np.arange(PIECE / 4).reshape(2, -1),
    ],
    ids=["a number", "text", "none", "high byte first", "by columns", "more than a piece"],
)
def test_an_array_of_an_npz_comes_back(tmp_path, array, compress):
    write_npz(tmp_path / "a.npz", {"a": array}, compress=compress)
    read = read_arrays(tmp_path / "a.npz", ["a", "b"], array.nbytes + 1000)["a"]
    assert (read.dtype, read.shape) == (array.dtype, array.shape)
    np.testing.assert_array_equal(read, array)


def claiming_more_than_it_holds():
    stream = io.BytesIO()
    header = {"descr": "<f8", "fortran_order": False, "shape": (2**40,)}
    np.lib.format.write_array_header_1_0(stream, header)
    return stream.getvalue() + bytes(80)


def cut_short():
    """A header that counts as if itself were values."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<u1", "fortran_order": False, "shape": (100,)})
    return stream.getvalue() + bytes(80)


def pickled():
    stream = io.BytesIO()
    np.save(stream, np.array([{}], dtype=object), allow_pickle=True)
    return stream.getvalue()


@pytest.mark.parametrize("content", [b"", b"nothing", claiming_more_than_it_holds(), pickled(), cut_short()])
def test_a_damaged_npy_file_is_said_by_name(tmp_path, content):
    (tmp_path / "a.npy").write_bytes(content)
    with pytest.raises(ValueError, match=r"a\.npy is damaged or no npy file of numbers or text"):
        read_npy(tmp_path / "a.npy")


def packed(path, header, values=b"", version=b"\x01\x00"):
    """An npz whose one array says `header` of itself, and holds other values."""
    length = len(header).to_bytes(2 if version == b"\x01\x00" else 4, "little")
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.npy", b"\x93NUMPY" + version + length + header + values)
    return path


def most_held(work):
    """Bytes that Python held at most while it worked, and what it raised."""
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=r"^it") as raised:
            work()
        return tracemalloc.get_traced_memory()[1], str(raised.value)
    finally:
        tracemalloc.stop()


@pytest.mark.later
def test_what_unpacks_to_far_more_than_numbers_do_is_refused_unread(tmp_path):
    np.savez_compressed(tmp_path / "bomb.npz", a=np.zeros((UNPACKED_FREELY // 8) + 1))
    np.savez_compressed(tmp_path / "still.npz", a=np.zeros(2**18))
    held, why = most_held(lambda: read_arrays(tmp_path / "bomb.npz", ["a"], 2**40))
    assert "it would unpack to 0.1 GiB" in why
    assert held < 2**20
    assert len(read_arrays(tmp_path / "still.npz", ["a"], 2**40)["a"]) == 2**18


def test_a_header_longer_than_any_is_not_read(tmp_path):
    path = packed(tmp_path / "long.npz", b" " * 2**25, version=b"\x02\x00")
    held, why = most_held(lambda: read_arrays(path, ["a"], 2**40))
    assert why == "its 'a' is damaged or holds neither numbers nor text"
    assert held < 2**21


def test_as_many_empty_texts_as_there_are_grains_of_sand_are_refused(tmp_path):
    header = b"{'descr': '<U0', 'fortran_order': False, 'shape': (1000000000000,)}"
    path = packed(tmp_path / "sand.npz", header)
    with pytest.raises(ValueError, match="its 'a' is damaged"):
        read_arrays(path, ["a"], 2**40)


def test_shapes_are_checked_before_anything_is_unpacked(tmp_path):
    path = packed(tmp_path / "a.npz", b"{'descr': '<f8', 'fortran_order': False, 'shape': (3541856, 72)}")
    np.save(tmp_path / "a.npy", np.zeros((7, 5)))

    def check(shape):
        raise LookupError(shape)

    with pytest.raises(LookupError, match="3541856, 72"):
        read_arrays(path, ["a"], 2**40, check)
    with pytest.raises(LookupError, match="7, 5"):
        read_npy(tmp_path / "a.npy", check)


def test_whoever_asks_is_told_of_a_file_before_it_gets_its_name(tmp_path):
    told = []
    with told_of_writes(lambda new, path: told.append((new.read_text(), path.exists(), path.name))):
        write_json(tmp_path / "a.json", 1)
        with told_of_writes(lambda *_: told.append("both")):
            write_json(tmp_path / "a.json", 2)
    write_json(tmp_path / "a.json", 3)
    assert told == [("1\n", False, "a.json"), ("2\n", True, "a.json"), "both"]
