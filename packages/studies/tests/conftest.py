# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line's fixtures: studies run by the same commands, on the same results."""

from tests.headless.conftest import (
    drawn,
    drawn_results,
    made_once_here,
    motions,
    one_worker,
    sparse_results,
)

from .made_mhad import some_mhad

__all__ = [
    "drawn",
    "drawn_results",
    "made_once_here",
    "motions",
    "one_worker",
    "some_mhad",
    "sparse_results",
]
