# SPDX-License-Identifier: GPL-3.0-or-later
"""Every benchmark can still be started: their foundations move, and nothing else runs them."""

from importlib import import_module
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1].glob("benchmarks/*.py")


@pytest.mark.parametrize("name", sorted(path.stem for path in BENCHMARKS))
def test_it_is_imported(name):
    pytest.importorskip("bpy")
    import_module(f"benchmarks.{name}")
