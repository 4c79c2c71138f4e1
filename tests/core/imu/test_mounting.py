# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor that sat another way round than the simulated one."""

import numpy as np

from w2w.core.imu.calibration import mounting

from .made_pairs import TURN, pair, without_tissue


def test_how_the_sensor_sat_is_found():
    pairs = [pair(seed=seed, worn=without_tissue()) for seed in range(2)]
    assert np.degrees((mounting(pairs) * TURN.inv()).magnitude()) < 0.5
