# SPDX-License-Identifier: GPL-3.0-or-later
"""A reader of pickles from strangers: it calls only what it is given, in bounded time and memory.

Python's own readers believe what a pickle claims: sizes, places in the memo, keys that take for ever to
hash. This one knows the operations that writers of arrays use, and refuses all others.
"""

import codecs
import pickle
import struct
from collections.abc import Callable, Iterable
from typing import Any, ClassVar, NoReturn

import numpy as np

from .files import UNPACKED_FREELY
from .wording import clean

FREE_STEPS, BYTES_A_STEP = 2**22, 2
"""Operations that any pickle may have, and bytes that each further one needs: most writers take more."""

FREE_MEMO, BYTES_A_MEMO = 2**20, 16
"""The same of objects that are kept to be named again."""

MOST_STACKED, STEPS = 2**20, 2**10
"""Objects that wait for their list, of which writers fill in a thousand at a time, and operations between
two looks at them."""

DEEPEST, MOST_MARKS = 50, 250
"""Lists, tuples and dicts inside each other, and marks of those that are not yet full."""

ITEM_BYTES = 16
"""What an item of a list or dict counts besides the bytes of arrays, when the whole is weighed."""

LONGEST_KEY, WIDEST_KEY = 1000, 8
"""Letters of a name in a dict, and names in one that is a tuple."""

LONGEST_INTEGER = 9
"""Bytes of an integer that an array may hold, with its sign."""

DAMAGED_PICKLE = "it is damaged, or no pickle of a model or motion"


class RefusedPickleError(ValueError):
    """A pickle that asks for more than arrays, or is damaged; the message says what."""


class StandIn:
    """An object that a pickle makes first and fills afterwards by a state."""

    fault: ClassVar[str] = "it holds an object that is no array"
    key: int | None = None  # in the memo

    def filled(self, _state: Any, _pickled: "Unpickler") -> Any:
        """What takes its place, here and in the memo."""
        return self


def _no_store(_reference: Any) -> NoReturn:
    raise RefusedPickleError("it refers to arrays that it does not hold")


class Unpickler:
    """Reads a pickle: containers, numbers and text, and what `find` gives for a module and a name.

    A function that it gives is called with the unpickler and the pickle's arguments. `stored` gives arrays
    that the pickle refers to, of `stored_bytes` in all.
    """

    def __init__(
        self,
        data: bytes,
        find: Callable[[str, str], Any],
        stored: Callable[[Any], np.ndarray] = _no_store,
        stored_bytes: int = 0,
    ) -> None:
        self.data, self.at, self.find, self.stored = data, 0, find, stored
        self.stack: list[Any] = []
        self.marks: list[int] = []
        self.memo: dict[int, Any] = {}
        self._held = len(data) + stored_bytes
        self._left = UNPACKED_FREELY + 2 * self._held

    def load(self) -> Any:
        """The pickle's content; RefusedPickleError if it is damaged or asks for more than arrays."""
        try:
            content = self._run()
            _weigh([content], UNPACKED_FREELY + ITEM_BYTES * self._held, {})
        except RefusedPickleError:
            raise
        except Exception as error:  # a damaged pickle raises anything
            raise RefusedPickleError(DAMAGED_PICKLE) from error
        return content

    def _run(self) -> Any:
        data, stack, push = self.data, self.stack, self.stack.append
        for _ in range(FREE_STEPS // STEPS + len(data) // (BYTES_A_STEP * STEPS)):
            for _ in range(STEPS):
                code = data[self.at]
                self.at += 1
                if read := VALUES[code]:
                    push(read(self))
                elif code != pickle.STOP[0]:
                    OPERATIONS[code](self)
                else:
                    return stack.pop()
            if len(stack) > MOST_STACKED or len(self.memo) > FREE_MEMO + len(data) // BYTES_A_MEMO:
                break
        raise RefusedPickleError("it takes more steps, or remembers more, than any model or motion needs")

    def spend(self, size: int) -> None:
        """Refuse the pickle if it makes many times more bytes than it holds."""
        self._left -= size
        if self._left < 0:
            raise RefusedPickleError("it unpacks to more than any model or motion needs")

    def take(self, size: int) -> bytes | memoryview:
        """The next bytes of the file."""
        self.look_ahead(size)
        start, self.at = self.at, self.at + size
        return self.data[start : self.at] if size <= LONGEST_KEY else memoryview(self.data)[start : self.at]

    def look_ahead(self, size: int) -> None:
        """Refuse the pickle if it claims more bytes than follow."""
        if not 0 <= size <= len(self.data) - self.at:
            raise RefusedPickleError(DAMAGED_PICKLE)

    def number(self, form: struct.Struct) -> Any:
        """The next number."""
        (value,) = form.unpack_from(self.data, self.at)
        self.at += form.size
        return value

    def byte(self) -> int:
        """The next byte."""
        self.at += 1
        return self.data[self.at - 1]

    def line(self) -> bytes:
        """The next line, of a pickle that is text."""
        start, self.at = self.at, self.data.index(b"\n", self.at) + 1
        return self.data[start : self.at - 1]

    def mark(self) -> None:
        """Put a mark on the stack."""
        self.marks.append(len(self.stack))
        if len(self.marks) > MOST_MARKS:
            raise RefusedPickleError("it begins more lists inside each other than any model or motion")

    def since_mark(self) -> list[Any]:
        """What was put on the stack since the last mark, taken off it."""
        return self.last(len(self.stack) - self.marks.pop())

    def last(self, count: int) -> list[Any]:
        """The last items on the stack, taken off it."""
        start = len(self.stack) - count
        items = self.stack[start:]
        del self.stack[start:]
        return items

    def keep(self, key: int | None = None) -> None:
        """Remember the top of the stack."""
        key, value = len(self.memo) if key is None else key, self.stack[-1]
        self.memo[key] = value
        if isinstance(value, StandIn):
            value.key = key

    def named(self, module: Any, name: Any) -> Any:
        """What a name stands for."""
        return self.find(clean(module[:LONGEST_KEY]), clean(name[:LONGEST_KEY]))

    def call(self) -> None:
        """Call the function on the stack with the tuple on top of it."""
        arguments, function = self.stack.pop(), self.stack.pop()
        if not callable(function) or type(arguments) is not tuple:
            raise RefusedPickleError(StandIn.fault)
        self.stack.append(function(self, *arguments))

    def fill(self) -> None:
        """Fill the object on the stack by the state on top of it."""
        state, made = self.stack.pop(), self.stack[-1]
        if not isinstance(made, StandIn):
            raise RefusedPickleError("it fills something that is no array")
        self.stack[-1] = value = made.filled(state, self)
        if made.key is not None:
            self.memo[made.key] = value

    def add(self, items: list[Any]) -> None:
        """Add items to the list, or keys and values in turn to the dict, on the stack."""
        if type(self.stack[-1]) is dict:
            self.stack[-1].update(in_turn(items))
        elif type(self.stack[-1]) is list:
            self.stack[-1] += items
        else:
            raise RefusedPickleError("it fills something that is no list")


def in_turn(items: list[Any]) -> dict[Any, Any]:
    """A dict of keys and values in turn."""
    return pairs(zip(items[::2], items[1::2], strict=True))


def pairs(items: Iterable[Any]) -> dict[Any, Any]:
    """A dict of pairs; its keys must be words or numbers, or a few of them."""
    found = {}
    for key, value in items:
        if type(key) is not str or len(key) > LONGEST_KEY:
            parts = key if type(key) is tuple else (key,)
            if len(parts) > WIDEST_KEY or not all(map(_is_short, parts)):
                raise RefusedPickleError("it has keys that are neither words nor numbers")
        found[key] = value
    return found


def _is_short(part: Any) -> bool:
    if isinstance(part, str | bytes):
        return len(part) <= LONGEST_KEY
    return part is None or isinstance(part, int | float)


def _weigh(value: Any, most: int, known: dict[int, tuple[int, int]]) -> tuple[int, int]:
    """Weight of a value and of all it refers to, as often as it does so, and how deep it goes.

    Raises RefusedPickleError for what nobody could walk through: endless, too deep, or far larger than
    the file.
    """
    if isinstance(value, np.ndarray):
        return value.nbytes, 0
    if id(value) not in known:
        known[id(value)] = most + 1, 0  # if it leads back to itself
        weight, depth = ITEM_BYTES * len(value), 0
        for part in value.values() if type(value) is dict else value:
            if type(part) in WEIGHTY:
                of_part, below = _weigh(part, most, known)
                weight, depth = weight + of_part, max(depth, below + 1)
            elif type(part) in LONG:
                weight += len(part)
        if weight > most or depth > DEEPEST:
            raise RefusedPickleError("it refers to itself, or again and again to the same, as no motion does")
        known[id(value)] = weight, depth
    return known[id(value)]


WEIGHTY = frozenset({list, tuple, dict, np.ndarray})
LONG = frozenset({str, bytes, memoryview})


def _long(data: bytes | memoryview) -> int:
    if len(data) > LONGEST_INTEGER:
        raise RefusedPickleError("it holds an integer that is too large for any array")
    return int.from_bytes(data, "little", signed=True)


def _integer(pickled: Unpickler) -> int:
    """A number of a pickle that is text, or a truth."""
    line = pickled.line()
    if line in (b"00", b"01"):
        return line == b"01"
    value = int(line.rstrip(b"L"))
    return _long(value.to_bytes(value.bit_length() // 8 + 1, "little", signed=True))


def _old_line(pickled: Unpickler) -> Any:
    text: bytes = codecs.escape_decode(pickled.line().strip()[1:-1])[0]
    return _old_text(text if len(text) <= LONGEST_KEY else memoryview(text))


def _old_text(data: bytes | memoryview) -> Any:
    """Text of Python 2; what is long is the bytes of an array."""
    return data if isinstance(data, memoryview) else data.decode("latin-1")


def _utf8(data: bytes | memoryview) -> str:
    return str(data, "utf-8", "surrogatepass")


SHORT, SIGNED, SIZE, LONG_SIZE, FLOAT = map(struct.Struct, ("<H", "<i", "<I", "<Q", ">d"))

_VALUES: dict[bytes, Callable[[Unpickler], Any]] = {
    pickle.NONE: lambda _: None, pickle.NEWTRUE: lambda _: True, pickle.NEWFALSE: lambda _: False,
    pickle.INT: _integer, pickle.LONG: _integer,
    pickle.BININT: lambda p: p.number(SIGNED), pickle.BININT2: lambda p: p.number(SHORT),
    pickle.BININT1: Unpickler.byte,
    pickle.LONG1: lambda p: _long(p.take(p.byte())), pickle.LONG4: lambda p: _long(p.take(p.number(SIGNED))),
    pickle.FLOAT: lambda p: float(p.line()), pickle.BINFLOAT: lambda p: p.number(FLOAT),
    pickle.STRING: _old_line, pickle.SHORT_BINSTRING: lambda p: _old_text(p.take(p.byte())),
    pickle.BINSTRING: lambda p: _old_text(p.take(p.number(SIGNED))),
    pickle.UNICODE: lambda p: str(p.line(), "raw-unicode-escape"),
    pickle.SHORT_BINUNICODE: lambda p: _utf8(p.take(p.byte())),
    pickle.BINUNICODE: lambda p: _utf8(p.take(p.number(SIZE))),
    pickle.SHORT_BINBYTES: lambda p: p.take(p.byte()), pickle.BINBYTES: lambda p: p.take(p.number(SIZE)),
    pickle.BYTEARRAY8: lambda p: p.take(p.number(LONG_SIZE)),
    pickle.EMPTY_LIST: lambda _: [], pickle.EMPTY_DICT: lambda _: {}, pickle.EMPTY_TUPLE: lambda _: (),
    pickle.EMPTY_SET: lambda _: [],  # nobody needs a set, and nothing has to be hashed
    pickle.LIST: Unpickler.since_mark, pickle.DICT: lambda p: in_turn(p.since_mark()),
    pickle.TUPLE: lambda p: tuple(p.since_mark()), pickle.TUPLE1: lambda p: tuple(p.last(1)),
    pickle.TUPLE2: lambda p: tuple(p.last(2)), pickle.TUPLE3: lambda p: tuple(p.last(3)),
    pickle.GET: lambda p: p.memo[int(p.line())], pickle.BINGET: lambda p: p.memo[p.byte()],
    pickle.LONG_BINGET: lambda p: p.memo[p.number(SIZE)],
    pickle.GLOBAL: lambda p: p.named(p.line().decode(), p.line().decode()),
    pickle.STACK_GLOBAL: lambda p: p.named(*p.last(2)),
    pickle.BINPERSID: lambda p: p.stored(p.stack.pop()),
}  # fmt: skip
VALUES = [_VALUES.get(bytes([code])) for code in range(256)]
"""Operations that put a value on the stack, by their code."""

_OPERATIONS: dict[bytes, Callable[[Unpickler], Any]] = {
    pickle.PROTO: Unpickler.byte, pickle.FRAME: lambda p: p.look_ahead(p.number(LONG_SIZE)),
    pickle.PUT: lambda p: p.keep(int(p.line())), pickle.BINPUT: lambda p: p.keep(p.byte()),
    pickle.LONG_BINPUT: lambda p: p.keep(p.number(SIZE)), pickle.MEMOIZE: Unpickler.keep,
    pickle.APPEND: lambda p: p.add(p.last(1)), pickle.SETITEM: lambda p: p.add(p.last(2)),
    pickle.MARK: Unpickler.mark, pickle.APPENDS: lambda p: p.add(p.since_mark()),
    pickle.ADDITEMS: lambda p: p.add(p.since_mark()), pickle.SETITEMS: lambda p: p.add(p.since_mark()),
    pickle.REDUCE: Unpickler.call, pickle.NEWOBJ: Unpickler.call, pickle.BUILD: Unpickler.fill,
}  # fmt: skip
OPERATIONS = {code[0]: operation for code, operation in _OPERATIONS.items()}
"""The others. What no writer of arrays uses is not there: to copy or drop the top, to call old classes, to
take numbers of registered extensions or buffers from elsewhere."""
