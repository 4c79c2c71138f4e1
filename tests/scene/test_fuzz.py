# SPDX-License-Identifier: GPL-3.0-or-later
"""Damaged files get a sentence from every reader; `tests.robustness.fuzz` and `formats` try far more."""

import pytest

from ..robustness.formats import KINDS, fuzz_here
from ..robustness.fuzz import fuzz_readers


@pytest.mark.usefixtures("shared_data")
@pytest.mark.parametrize("seed", [1, *(pytest.param(night, marks=pytest.mark.slow) for night in (2, 3))])
def test_readers_survive_damaged_files(tmp_path, seed):
    found = fuzz_readers(tmp_path, 300, seed)
    assert not [name for name in found if name.startswith("FAULT")]
    assert sum(found.values()) == 300
    assert all(found[f"{name}: refused with a sentence"] for name in ("AMASS npz", "labels csv", "FBX check"))


BY_BLENDER = (".fbx", ".glb", ".gltf", ".usda", ".usdc")
MAY_DIE = (".c3d", ".usdc", ".fbx")
"""Kinds whose libraries crash on some damage: they are read in a worker of their own."""


@pytest.mark.parametrize(
    ("cases", "kinds"),
    [
        (4, [kind for kind in KINDS if kind not in (*BY_BLENDER, *MAY_DIE)]),
        pytest.param(20, [kind for kind in KINDS if kind not in MAY_DIE], marks=pytest.mark.slow),
    ],
)
def test_damaged_files_of_every_kind_are_read_or_refused_without_a_warning(tmp_path, cases, kinds):
    found = fuzz_here(tmp_path, kinds, cases, seed=1)
    assert not [name for name in found if name.startswith("FAULT")]
    assert all(found[f"{kind}: read"] for kind in kinds)  # the first two of each are whole
    assert sum(found[f"{kind}: refused"] for kind in kinds) > sum(found.values()) / 3
