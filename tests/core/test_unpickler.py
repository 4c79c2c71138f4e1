# SPDX-License-Identifier: GPL-3.0-or-later
"""Pickles of arrays by every protocol and both NumPys read as Python reads them, and hostile ones refused."""

import io
import pickle
import pickletools
import struct
import subprocess
import sys
from collections import OrderedDict
from contextlib import suppress

import joblib
import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy import sparse

from w2w.core import unpickler
from w2w.core.pickles import read_arrays, read_npy_object, read_result
from w2w.core.stand_ins import stand_in
from w2w.core.unpickler import DEEPEST, OPERATIONS, VALUES, RefusedPickleError, Unpickler

from ..patience import HANG_S

PROTOCOLS = range(pickle.HIGHEST_PROTOCOL + 1)
TYPES = ("?", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f2", "f4", "f8", "S3", "U3")


def load(data):
    return Unpickler(data, stand_in).load()


def of_numpy_2(data):
    """The same pickle with the module's name that NumPy 2 writes."""
    return data.replace(b"cnumpy.core.", b"cnumpy._core.").replace(b"\x15numpy.core.m", b"\x16numpy._core.m")


class Python2Pickler(pickle._Pickler):
    """Writes bytes as Python 2 wrote its strings."""

    def save_bytes(self, value):
        if self.bin:
            self.write(b"T" + struct.pack("<i", len(value)) + value)
        else:
            self.write(b"S" + repr(value)[1:].encode() + b"\n")
        self.memoize(value)

    dispatch = pickle._Pickler.dispatch | {bytes: save_bytes}


def by_python_2(content, protocol):
    stream = io.BytesIO()
    Python2Pickler(stream, protocol).dump(content)
    return stream.getvalue()


def arrays(code):
    numbers = np.arange(-6, 18).astype("f8").reshape(2, 3, 4)
    array = (numbers.astype("i8") % 128).astype(code) if code[0] in "?iuSU" else numbers.astype(code)
    yield from (
        array,
        np.asfortranarray(array),
        array.T,
        array[0, 0, 0],
        array[:, ::2],
        array[:0],
        array.ravel(),
    )


def assert_same(found, expected):
    if isinstance(expected, dict):
        assert found.keys() == expected.keys()
        for key, value in expected.items():
            assert_same(found[key], value)
    elif isinstance(expected, np.ndarray) and not expected.dtype.hasobject:
        assert (found.dtype, found.shape) == (expected.dtype.newbyteorder("="), expected.shape)
        np.testing.assert_array_equal(found, expected)
    elif isinstance(expected, list | tuple):
        assert type(found) is type(expected)
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            assert_same(one, other)
    else:
        assert found == (expected.tolist() if isinstance(expected, np.ndarray) else expected)


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("order", "<>")
def test_arrays_of_every_type_are_read_as_python_reads_them(protocol, order):
    kinds = [np.dtype(code).newbyteorder(order).str for code in TYPES]
    content = {kind: {str(n): array for n, array in enumerate(arrays(kind))} for kind in kinds}
    pickled = pickle.dumps(content, protocol)
    assert_same(load(pickled), content)
    assert_same(load(of_numpy_2(pickled)), content)
    if protocol < 3:
        assert_same(load(by_python_2(content, protocol)), content)


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_containers_scalars_and_arrays_of_objects_are_read_as_python_reads_them(tmp_path, protocol):
    ragged = np.empty((2, 2), dtype=object)
    ragged[:] = [[np.arange(3), "a"], [None, {"b": 2.5}]]
    shared = np.arange(5.0)
    content = {
        "words": ["", "ä", "x" * 3000, b"\x80", b"y" * 3000],
        "numbers": [0, 1, -1, 255, 256, 70_000, -(2**31), 2**63 - 1, 1.5, float("inf"), True, False, None],
        "tuples": [(), (1,), (1, 2), (1, 2, 3), (1, 2, 3, 4), ((1, 2), [])],
        "scalars": [np.float32(1.5), np.int64(-7), np.bool_(True), np.str_("word"), np.bytes_(b"z")],
        "again": [shared, shared, {"it": shared}],
        "long": list(range(2500)),
        "ordered": dict(OrderedDict(one=1, two=2)),
        3: "three",
        ("walk", 1): "pair",
    }
    assert_same(load(pickle.dumps(content, protocol)), content)
    assert_same(load(pickle.dumps(OrderedDict(one=1), protocol)), {"one": 1})
    assert sorted(load(pickle.dumps({1, 2, 3}, protocol))) == [1, 2, 3]
    assert_same(load(pickle.dumps({"held": ragged}, protocol)), {"held": ragged.tolist()})
    assert load(pickle.dumps(np.array({"a": 1}, dtype=object), protocol)) == {"a": 1}
    for kind in (sparse.csc_matrix, sparse.csr_matrix, sparse.csr_array):
        matrix = kind(np.array([[0, 2.0, 0], [0, 0, 0], [1, 0, 3]]))
        (tmp_path / "m.pkl").write_bytes(pickle.dumps({"m": matrix}, protocol))
        found = read_arrays(tmp_path / "m.pkl", ("m",))
        np.testing.assert_array_equal(found["m"], matrix.toarray())


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("compress", [0, 3])
def test_what_joblib_wrote_is_read(tmp_path, protocol, compress):
    content = {str(n): array for n, array in enumerate(arrays("f4"))} | {"words": ["a"] * 3}
    joblib.dump(content, tmp_path / "a.pkl", compress=compress, protocol=protocol)
    assert_same(read_result(tmp_path / "a.pkl"), content)


def test_files_of_objects_are_read_as_numpy_reads_them(tmp_path):
    for held in ({"motion": np.zeros(3)}, [np.zeros(2), np.ones(3)], [{"a": 1}]):
        array = np.empty(() if isinstance(held, dict) else len(held), dtype=object)
        array[...] = held
        np.save(tmp_path / "a.npy", array)
        expected = np.load(tmp_path / "a.npy", allow_pickle=True)
        assert_same(read_npy_object(tmp_path / "a.npy"), expected.item() if expected.size == 1 else held)


# --- refused


def dtype_with(state, code=b"f8"):
    """A pickled array whose type gets some state."""
    made = pickle.dumps(np.zeros(1), 2)
    known = pickle.dumps((3, "<", None, None, None, -1, -1, 0), 2)[2:-1]
    inside = b"(" + b"".join(pickle.dumps(part, 2)[2:-1] for part in state) + b"t"
    start = made.index(b"(K\x03X\x01\x00\x00\x00<")
    stop = made.index(b"tq", start) + 1
    assert known
    return made[:start].replace(b"X\x02\x00\x00\x00f8", b"X\x02\x00\x00\x00" + code) + inside + made[stop:]


def array_with(*state):
    """An array of `numpy._reconstruct` with some state, written as a pickle."""

    class Claimed:
        def __reduce__(self):
            return np.core.multiarray._reconstruct, (np.ndarray, (0,), b"b"), state

    return pickle.dumps({"poses": Claimed()}, 2)


F8, LITTLE = np.dtype("f8"), (3, "<", None, None, None, -1, -1, 0)
HIDDEN = (3, "|", None, ("a",), {"a": (np.dtype("O"), 0)}, 8, 1, 0)
"""The state of a type that hides an object."""

FLOOD = 2 * 2**20


def nested(depth, close=b"."):
    return b"\x80\x04" + b"]" * depth + b"a" * (depth - 1) + close


def doubled(times):
    """A list of two of the same list of two of the same, and so on."""
    data = b"\x80\x04]\x94K\x00a0".replace(b"0", b"")
    for n in range(times):
        data += b"](h%ch%ce\x94" % (n, n)
    return data + b"."


def wide(width):
    """A list of lists, all the same and as wide."""
    return b"\x80\x04]\x94(" + b"K\x00" * width + b"e](" + b"h\x00" * width + b"e."


def long_key(length):
    return b"\x80\x04}X" + struct.pack("<I", length) + b"a" * length + b"K\x01s."


HOSTILE = {
    "a type that hides an object": dtype_with(HIDDEN, b"V8"),
    "a number's type with fields": dtype_with(HIDDEN),
    "a type made of arrays": dtype_with((3, "|", (F8, (2,)), None, None, 16, 8, 0)),
    "a type larger than it is": dtype_with((3, "<", None, None, None, 64, 8, 0)),
    "a type with flags": dtype_with((3, "<", None, None, None, -1, -1, 63)),
    "a type of a later version": dtype_with((4, "<", None, None, None, -1, -1, 0, {})),
    "a type of objects without flags": dtype_with((3, "|", None, None, None, -1, -1, 0), b"O8"),
    "a structured type by its name": dtype_with(LITTLE, b"i4,O8"[:2]),
    "more than it holds": array_with(1, (2,), F8, False, bytes(8)),
    "less than it holds": array_with(1, (0,), F8, False, bytes(8)),
    "a size below nothing": array_with(1, (-1, -1), F8, False, bytes(8)),
    "a size that overflows": array_with(1, (2**32, 2**32), F8, False, b""),
    "a size of nothing and more": array_with(1, (2**40, 0), F8, False, b""),
    "as many dimensions as it likes": array_with(1, (1,) * 33, F8, False, bytes(8)),
    "objects as bytes": array_with(1, (1,), np.dtype("O"), False, bytes(8)),
    "numbers as objects": array_with(1, (1,), F8, False, [1.0]),
    "letters that do not exist": array_with(1, (1,), np.dtype("U1"), False, b"\xff\xff\xff\xff"),
    "a type that is none": array_with(1, (1,), "f8", False, bytes(8)),
    "a tuple in a tuple as a key": pickle.dumps({((1, 2), 3): 4}),
    "a frozen set as a key": pickle.dumps({frozenset({1}): 2}),
    "tuples of tuples as a key": b"\x80\x02})" + b"q\x00h\x00\x86" * 40 + b"K\x01s.",
    "a key as long as a book": long_key(5000),
    "a large number as a key": b"\x80\x04}\x8b" + struct.pack("<i", 20_000) + bytes(19_999) + b"\x01K\x01s.",
    "a list in itself": b"\x80\x04]\x94h\x00a.",
    "lists in lists": nested(DEEPEST + 2),
    "lists in lists in lists": nested(10**5),
    "the same twice, twice, twice": doubled(60),
    "the same again and again": wide(10_000),
    "copies of the top": b"\x80\x02]" + b"2" * 100 + b".",
    "bytes that are not there": b"\x80\x05\x96" + struct.pack("<Q", 2**40) + b".",
    "text that is not there": b"\x80\x04X\xff\xff\xff\xffab.",
    "old text of less than nothing": b"\x80\x02T\xff\xff\xff\xffab.",
    "a frame that is not there": b"\x80\x04\x95" + struct.pack("<Q", 2**62) + b"N.",
    "a registered extension": b"\x80\x02\x82\x01.",
    "buffers from elsewhere": b"\x80\x05\x97.",
    "an instance": b"(iposix\nsystem\n.",
    "an object": b"(cposix\nsystem\no.",
    "something persistent": b"Pabc\n.",
    "something persistent from the stack": b"\x80\x02K\x01Q.",
    "a function with keywords": b"\x80\x04cnumpy\ndtype\n)}\x92.",
    "an empty file": b"",
    "no stop": b"\x80\x04N",
    "no mark": b"\x80\x04NNe.",
    "filling a function": b"\x80\x02cnumpy\ndtype\n}b.",
    "filling an array twice": pickle.dumps(np.zeros(1), 2)[:-1] + b"}b.",
    "calling a list": b"\x80\x02])R.",
    "adding to a tuple": b"\x80\x04)Na.",
    "a sparse matrix of more than memory": pickle.dumps(sparse.csc_matrix((2**20, 2**20)), 2),
    "a name of no text": b"\x80\x04K\x01K\x02\x93.",
}
FLOODS = {
    "sets": b"\x80\x04" + b"\x8f" * FLOOD,
    "lists": b"\x80\x04" + b"]" * FLOOD,
    "dicts": b"\x80\x04" + b"}" * FLOOD,
    "tuples": b"\x80\x04" + b")" * FLOOD,
    "nothings": b"\x80\x04" + b"N" * FLOOD,
    "marks": b"\x80\x04" + b"(" * FLOOD,
    "what it remembers": b"\x80\x04]" + b"\x94" * FLOOD,
}


@pytest.mark.parametrize("name", list(HOSTILE))
def test_hostile_pickles_are_refused(name):
    with pytest.raises(RefusedPickleError):
        load(HOSTILE[name])


def test_steps_end(monkeypatch):
    data = b"\x80\x04]" + b"Na" * 2**12 + b"."
    assert len(load(data)) == 2**12
    monkeypatch.setattr(unpickler, "FREE_STEPS", 2**10)
    with pytest.raises(RefusedPickleError, match="more steps"):
        load(data)


def test_a_far_key_of_the_memo_takes_no_memory():
    assert load(b"\x80\x04Nr\xff\xff\xff\xff.") is None


def test_a_type_changed_in_the_tests_above_is_otherwise_read():
    """So that those are refused for what is wrong with them."""
    np.testing.assert_array_equal(load(dtype_with(LITTLE)), np.zeros(1))
    np.testing.assert_array_equal(load(array_with(1, (1,), F8, False, bytes(8)))["poses"], np.zeros(1))
    assert load(nested(DEEPEST)) is not None
    assert load(doubled(10)) is not None
    assert load(long_key(1000)) == {"a" * 1000: 1}


SMALL_PROCESS = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (2**30, 2**30))
from pathlib import Path
from w2w.core.pickles import read_result
for path in map(Path, sys.argv[1:]):
    try:
        read_result(path)
    except ValueError as error:
        print(path.name, error)
"""


@pytest.mark.later
@pytest.mark.skipif(sys.platform == "win32", reason="limits of memory are the system's")
def test_hostile_pickles_take_no_memory_nor_time(tmp_path):
    files = []
    for number, data in enumerate((HOSTILE | FLOODS).values()):
        files.append(tmp_path / f"{number}.pkl")
        files[-1].write_bytes(data)
    call = [sys.executable, "-c", SMALL_PROCESS, *map(str, files)]
    ended = subprocess.run(call, capture_output=True, text=True, timeout=HANG_S, check=False)
    assert ended.returncode == 0, ended.stderr
    assert len(ended.stdout.splitlines()) == len(HOSTILE | FLOODS)


def test_the_cases_are_refused(shared_cases):
    with pytest.raises(RefusedPickleError):
        read_npy_object(shared_cases / "second" / "segv_hidden_object_dtype.npy")
    with pytest.raises(RefusedPickleError):
        read_result(shared_cases / "second" / "hang_tuple_key.pkl")


WHOLE = [
    pickle.dumps({"poses": np.zeros((4, 72)), "trans": np.ones((4, 3), "f4"), "names": ["a", "b"]}, protocol)
    for protocol in PROTOCOLS
]


@given(st.sampled_from(WHOLE), st.lists(st.tuples(st.integers(0, 2**16), st.binary(max_size=4)), max_size=4))
def test_damaged_pickles_are_read_or_refused(whole, changes):
    data = bytearray(whole)
    for place, change in changes:
        start = place % len(data)
        data[start : start + len(change)] = change
    with suppress(RefusedPickleError):
        load(bytes(data))


def test_only_operations_that_pickle_knows_are_read():
    known = {ord(operation.code) for operation in pickletools.opcodes}
    assert {code for code, value in enumerate(VALUES) if value} | OPERATIONS.keys() < known
