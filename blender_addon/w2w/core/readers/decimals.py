# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines of decimal numbers as a table: all digits of a text at once, in half of `np.loadtxt`'s time.

A number of at most `EXACT` over a power of ten that is exact, too, rounds once, as `float` does.
"""

from collections.abc import Sequence

import numpy as np

MOST_DIGITS, MOST_IN_ALL = 16, 18
"""Digits in a row, and those on both sides of a point, that are read here."""

EXACT, MOST_PLACES = 2**53, 22
"""Whole numbers and powers of ten up to these are exact in double precision."""

TENS = 10 ** np.arange(MOST_IN_ALL + 1, dtype=np.int64)
POWERS = 10.0 ** np.arange(MOST_PLACES + 1)

JOINS = (
    (0x0F0F0F0F0F0F0F0F, 10 << 8 | 1, 8),
    (0x00FF00FF00FF00FF, 100 << 16 | 1, 16),
    (0x0000FFFF0000FFFF, 10_000 << 32 | 1, 32),
)
"""Bits that are kept of eight digits, a factor and a shift: neighbours make pairs, then fours, then all."""


def decimal_table(lines: Sequence[str], columns: int) -> np.ndarray | None:
    """Numbers of lines that are not blank, a row each; None if one is not plain or not so many are in a line.

    Plain is ``-12.5`` or ``1.2e-05``: any other way to write a number, right or wrong, is for others to read.
    """
    text = "".join(lines).encode()
    data = np.frombuffer(b" " * MOST_DIGITS + text + b" " * 8, np.uint8)
    digit = data - np.uint8(ord("0")) < 10
    edges = np.flatnonzero(digit[1:] != digit[:-1]) + 1
    starts, ends = np.ascontiguousarray(edges.reshape(-1, 2).T)
    size = ends - starts
    if len(size) < len(lines) * columns or size.max(initial=0) > MOST_DIGITS:
        return None
    # rows of digits are whole numbers, or what follows a point or e- of the row before
    before, gap = data.take(starts - 1), starts.copy()
    gap[1:] -= ends[:-1]
    minus = before == ord("-")
    after, raised = (before == ord(".")) & (gap == 1), np.flatnonzero(minus & (gap == 2))
    raised = raised[data[starts[raised] - 2] == ord("e")]
    part = after.view(np.int8)
    part[raised] = 2
    whole = np.flatnonzero(part == 0)
    minus, following = minus.take(whole), np.minimum(whole + 1, len(size) - 1)
    fraction = part.take(following) == 1
    used = size.sum() + 2 * len(raised) + np.count_nonzero(part == 1) + np.count_nonzero(minus)
    blanks = sum(np.count_nonzero(data == ord(blank)) for blank in " \n\t")
    if len(whole) != len(lines) * columns or used + blanks != len(data):
        return None
    if part[0] or np.count_nonzero(fraction) != np.count_nonzero(part == 1) or (part[raised - 1] == 2).any():
        return None
    rows = starts.take(whole).reshape(len(lines), columns) - MOST_DIGITS
    stop = np.cumsum([len(line) for line in lines])
    if (
        (rows[:, -1] >= stop).any()
        or (rows[1:, 0] < stop[:-1]).any()
        or (minus & (gap.take(whole) == 1)).any()
    ):
        return None
    digits, places = size.take(whole), size.take(following) * fraction
    if (digits + places).max() > MOST_IN_ALL:
        return None
    value = _whole_numbers(data, ends, size)
    numbers = value.take(whole) * TENS.take(places) + value.take(following) * fraction
    places[np.searchsorted(whole, raised) - 1] += value[raised]
    if numbers.max() > EXACT or places.max() > MOST_PLACES:
        return None
    scaled = numbers / POWERS.take(places)
    return np.where(minus, -scaled, scaled).reshape(rows.shape)


def _whole_numbers(data: np.ndarray, ends: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Whole numbers of at most sixteen digits by where they end in a text and their number of digits."""
    words, place = data[: len(data) // 8 * 8].view("<u8"), ends - 8 >> 3
    into, others = ((8 * bits).view(np.uint64) for bits in (ends & 7, 8 - np.minimum(size, 8)))
    held = words.take(place) >> into | words.take(place + 1) << np.uint64(64) - into
    held = held >> others << others  # what is before the digits is out
    for kept, factor, shift in JOINS:
        held = (held & np.uint64(kept)) * np.uint64(factor) >> np.uint64(shift)
    numbers = held.view(np.int64)
    long = np.flatnonzero(size > 8)
    if len(long):
        numbers[long] += TENS[8] * _whole_numbers(data, ends[long] - 8, size[long] - 8)
    return numbers
