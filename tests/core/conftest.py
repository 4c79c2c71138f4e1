# SPDX-License-Identifier: GPL-3.0-or-later
"""The core's fixtures: the patches are all those of the bundled body, unless a module has its own."""

import pytest

from w2w.core.patches.patches import PatchSet


@pytest.fixture(scope="session")
def patches(all_patches: PatchSet) -> PatchSet:
    """The bundled body's 512 patches."""
    return all_patches
