# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of decimal numbers are read as `float` reads each, or not at all."""

import random

import numpy as np
import pytest

from w2w.core.readers.decimals import decimal_table

ODD = (
    "-", "--1", "1-2", "1.2.3", "e-5", "1e-", "1e-5e-5", "1e-5.5", "1.e-5", ".", ".5", "1.", "1.-2", "1..2",
    "1 .5", "1. 5", "1- 2", "1e -5", "1e- 5", "٣", "1\x0b1", "1\x001", "1,5", "0x10", "1_0", "+3", "1e5",
    "1e--5", "-e-5", "1E-5", "1e-99999999999999999999", "1e-23", "nan", "inf", "9007199254740993",
    "12345678901234567", "1234567890123456.123", "1 2", "", "12345678.123456789",
)  # fmt: skip


def written(rng):
    """A number as programs write it."""
    value = rng.uniform(-1, 1) * 10 ** rng.randint(-8, 3)
    return rng.choice(["%.6f", "%.4f", "%.9f", "%g", "%.9g", "%d"]) % value


@pytest.mark.parametrize("end", ["\n", " \n", ""])
def test_numbers_are_those_of_float(end):
    rng = random.Random(1)
    rows = [[written(rng) for _ in range(60)] for _ in range(90)]
    rows[0][:6] = ["-0", "-0.000000", "007", "9007199254740992", "0.9007199254740991", "1e-22"]
    lines = [rng.choice([" ", "\t", "  "]).join(row) + "\n" for row in rows]
    lines[-1] = lines[-1].rstrip() + end
    wanted = np.array([[float(word) for word in row] for row in rows])
    assert decimal_table(lines, 60).tobytes() == wanted.tobytes()


@pytest.mark.parametrize("odd", ODD)
@pytest.mark.parametrize("place", [0, 7, 11])
def test_other_words_are_left_to_others_or_read_alike(odd, place):
    rows = [["1.5", "-2", "3e-05", "0.25"] for _ in range(3)]
    rows[place // 4][place % 4] = odd
    found = decimal_table([" ".join(row) + "\n" for row in rows], 4)
    if found is not None:
        assert found.tobytes() == np.array(rows, dtype=float).tobytes()


def test_lines_of_other_lengths_are_left_to_others():
    assert decimal_table(["1 2 3\n", "4\n"], 2) is None
    assert decimal_table(["1\n", "2 3 4\n"], 2) is None
    assert decimal_table(["1 2\n"], 0) is None
