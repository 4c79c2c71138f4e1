# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures every test may use: where the real data stands."""

from pathlib import Path

import pytest

SHARED_DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of real motions, recordings and bodies; tests that need it skip without it."""
    if not SHARED_DATA.is_dir():
        pytest.skip("the real data folder ../shared/data is not here")
    return SHARED_DATA
