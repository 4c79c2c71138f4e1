# SPDX-License-Identifier: GPL-3.0-or-later
"""Some windows of a record keep what belongs to them."""

from typing import NamedTuple

import numpy as np
import pytest

from w2w.core.windows.inputs import ArrayBlocks, PatchBlocks, SomeWindows
from w2w_studies.validation.some_windows import some_windows


class Held(NamedTuple):
    blocks: PatchBlocks
    name: np.ndarray
    skipped: dict


@pytest.fixture
def held():
    values = np.random.default_rng(0).normal(size=(6, 3, 2)).astype(np.float32)
    return Held(ArrayBlocks(values), np.array(list("abcdef")), {"g": "too short"})


def test_fields_with_a_row_a_window_are_cut_and_others_stay(held):
    found = some_windows(held, np.array([0, 1, 0, 0, 1, 1], bool))
    assert "".join(found.name) == "bef"
    assert found.skipped is held.skipped
    assert found.blocks.shape == (3, 3, 2)
    np.testing.assert_array_equal(found.blocks.patches(slice(1, 3)), held.blocks.array[[1, 4, 5], 1:3])


def test_some_of_some_are_read_straight_from_their_source(held):
    half = some_windows(held, held.name > "b")
    found = some_windows(half, np.array([1, 0, 0, 1], bool))
    assert "".join(found.name) == "cf"
    assert isinstance(found.blocks, SomeWindows)
    assert found.blocks.source is held.blocks
    np.testing.assert_array_equal(found.blocks.patches(slice(0, 3)), held.blocks.array[[2, 5]])
