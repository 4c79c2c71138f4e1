# SPDX-License-Identifier: GPL-3.0-or-later
"""Every benchmark can still be started: what it is built on moves, and nothing else runs it."""

from importlib import import_module
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.mark.parametrize("name", sorted(path.stem for path in BENCHMARKS.glob("*.py")))
def test_it_is_imported(name):
    pytest.importorskip("bpy")
    import_module(f"benchmarks.{name}")
