# SPDX-License-Identifier: GPL-3.0-or-later
"""Columns of joints, found by their names; the files of each program are in the tests of their readers."""

import re

import pytest
from hypothesis import given, strategies as st

from w2w.core.keypoints.facts import COLUMN, joint_columns


@pytest.mark.parametrize("letter", ["_", "-", ".", " ", "a"])
def test_a_header_is_searched_once_however_long_it_is(letter):
    """A million letters were gone over for each of them, which took hours."""
    assert joint_columns([letter * 2**20, f"{letter * 2**20}!"]) == {}


OLD_COLUMN = re.compile(r"(?P<joint>.*\S)[\s_.:\-]+(?P<axis>[xyz])", re.IGNORECASE | re.DOTALL)


@given(st.text(alphabet="aL _.:-\t\nxZ", max_size=12))
def test_a_column_of_a_joint_is_named_by_its_end(name):
    found, expected = COLUMN.fullmatch(name), OLD_COLUMN.fullmatch(name)
    assert (found and found.groups()) == (expected and expected.groups())
