# SPDX-License-Identifier: GPL-3.0-or-later
"""Rotation vectors are SciPy's to the bit."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.motion.rotation_vectors import rotation_vectors

TURNS = Rotation.random(2000, random_state=1).as_matrix()
AXES = TURNS[:, 0]
CUBE = Rotation.create_group("O").as_matrix().round() + 0.0


@pytest.mark.parametrize(
    "matrices",
    [
        TURNS,
        TURNS @ TURNS[::-1],
        CUBE,
        Rotation.from_rotvec(AXES * np.logspace(-17, 0, 2000)[:, None]).as_matrix(),
        Rotation.from_rotvec(AXES * (np.pi - np.logspace(-17, 0, 2000))[:, None]).as_matrix(),
        TURNS.astype(np.float32).astype(np.float64),
        TURNS * 1.001,
        TURNS[:0],
    ],
)
def test_rotation_vectors_are_scipys(matrices):
    assert rotation_vectors(matrices).tobytes() == Rotation.from_matrix(matrices).as_rotvec().tobytes()


def test_a_reflection_is_refused():
    with pytest.raises(ValueError, match="determinant"):
        rotation_vectors(-TURNS)
