# SPDX-License-Identifier: GPL-3.0-or-later
"""A little of Berkeley MHAD, so that a test takes seconds."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest


@pytest.fixture
def some_mhad(shared_data, tmp_path) -> Callable[[int, Sequence[str], Sequence[str]], Path]:
    """Writes so many people's repetitions of some actions into a file; gives its path."""

    def write(people: int, actions: Sequence[str], repetitions: Sequence[str]) -> Path:
        whole = np.load(shared_data / "imu" / "berkeley_mhad" / "acc.npz", allow_pickle=False)
        subjects = [f"s{number:02d}" for number in range(1, people + 1)]
        names = [
            name
            for name in whole.files
            if name[:3] in subjects and name[4:7] in actions and name[8:11] in repetitions
        ]
        path = tmp_path / "few.npz"
        np.savez(path, **{name: whole[name] for name in names})
        return path

    return write
