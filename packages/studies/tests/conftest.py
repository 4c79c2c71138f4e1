# SPDX-License-Identifier: GPL-3.0-or-later
"""The fixtures of the product's tests: studies run by the same commands, on the same results."""

from tests.conftest import (
    all_patches,
    bundled_body,
    door,
    made_files,
    made_once,
    pytest_collection_finish,
    pytest_sessionfinish,
    shared_cases,
    shared_data,
    torch,
    waving,
)
from tests.headless.conftest import (
    dear,
    drawn,
    drawn_results,
    made_once_here,
    motions,
    one_worker,
    sparse_results,
)

from .made_mhad import some_mhad

__all__ = [
    "all_patches",
    "bundled_body",
    "dear",
    "door",
    "drawn",
    "drawn_results",
    "made_files",
    "made_once",
    "made_once_here",
    "motions",
    "one_worker",
    "pytest_collection_finish",
    "pytest_sessionfinish",
    "shared_cases",
    "shared_data",
    "some_mhad",
    "sparse_results",
    "torch",
    "waving",
]
