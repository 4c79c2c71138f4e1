# SPDX-License-Identifier: GPL-3.0-or-later
"""Damaged files get a sentence from every reader; `python -m tests.robustness.fuzz` tries far more."""

import pytest

from ..robustness.fuzz import fuzz_readers


@pytest.mark.usefixtures("shared_data")
@pytest.mark.parametrize("seed", [1, *(pytest.param(night, marks=pytest.mark.slow) for night in (2, 3))])
def test_readers_survive_damaged_files(tmp_path, seed):
    found = fuzz_readers(tmp_path, 300, seed)
    assert not [name for name in found if name.startswith("FAULT")]
    assert sum(found.values()) == 300
    assert all(found[f"{name}: refused with a sentence"] for name in ("AMASS npz", "labels csv", "FBX check"))
