# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests that compare bits: which they are, and as which processors this one can pass them.

`python -m tests.bits` prints those processors as OPENBLAS_CORETYPE takes them.
"""

import re
from functools import cache
from pathlib import Path

import numpy as np

COMPARED = re.compile(
    r"array_equal\(|assert_equal\(|tobytes\(|read_bytes\(|sha256|== .*read_text\(|read_text\(.*=="
)
"""What a function holds that compares arrays or files by their bits."""

NEEDS = {"Prescott": "SSE3", "Haswell": "AVX2", "SkylakeX": "AVX512_SKX"}
"""What a processor must have for OpenBLAS's kernels of a kind, by NumPy's name; OpenBLAS does not look."""


@cache
def comparing(path: Path) -> frozenset[str]:
    """Functions of a module that compare bits, themselves or by another of its functions."""
    parts = re.split(r"^def (?=\w)", path.read_text("utf-8"), flags=re.MULTILINE)[1:]
    functions = {part[: part.index("(")]: part for part in parts}
    found = {name for name, part in functions.items() if COMPARED.search(part)}
    size = 0
    while size < len(found):
        size, called = len(found), re.compile(rf"\b({'|'.join(found)})\b")
        found |= {name for name, part in functions.items() if called.search(part)}
    return frozenset(found)


def kinds() -> list[str]:
    """The processors of which this one can run the kernels."""
    has = np.core._multiarray_umath.__cpu_features__
    return [kind for kind, feature in NEEDS.items() if has.get(feature)]


if __name__ == "__main__":
    print(*kinds())
