# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line's fixtures: studies run by the same commands, on the same results."""

from ..headless.conftest import drawn_results, motions, one_worker, placed_once, sparse_results
from .made_mhad import some_mhad

__all__ = ["drawn_results", "motions", "one_worker", "placed_once", "some_mhad", "sparse_results"]
