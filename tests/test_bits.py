# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests that compare bits are found, and passed with the kernels that were asked for."""

import os
import platform
import subprocess
import sys

import pytest

from . import bits
from .patience import HANG_S

MODULE = """
def same_files(one, other):
    assert one.read_bytes() == other.read_bytes()

@pytest.fixture
def twice(tmp_path):
    same_files(*make_twice(tmp_path))

def test_arrays(one, other):
    np.testing.assert_array_equal(one, other)

def test_texts(one, other):
    assert one.read_text("utf-8") == other.read_text("utf-8")

def test_by_another(tmp_path):
    same_files(tmp_path / "one", tmp_path / "other")

def test_by_a_fixture(twice):
    assert twice is None

def test_words(one):
    assert "same" in one
"""

KERNELS = """
import numpy, scipy.linalg, threadpoolctl
print(*(library["architecture"] for library in threadpoolctl.threadpool_info()))
"""


def test_what_compares_bits_is_found(tmp_path):
    module = tmp_path / "test_module.py"
    module.write_text(MODULE, "utf-8")
    tests = {name for name in bits.comparing(module) if name.startswith("test_")}
    assert tests == {"test_arrays", "test_texts", "test_by_another", "test_by_a_fixture"}


@pytest.mark.parametrize("kind", bits.kinds())
def test_every_library_takes_the_kernels_of_the_kind(kind):
    named = subprocess.run(
        [sys.executable, "-c", KERNELS],
        env=os.environ | {"OPENBLAS_CORETYPE": kind},
        capture_output=True,
        text=True,
        timeout=HANG_S,
    )
    # Katmai's kernels are Prescott's, and NumPy's library names the first that has them
    assert {name.replace("Katmai", "Prescott") for name in named.stdout.split()} == {kind}, named.stderr


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="the kinds are of x86")
def test_the_oldest_kind_is_always_tried():
    assert "Prescott" in bits.kinds()
