# SPDX-License-Identifier: GPL-3.0-or-later
"""A pose is told from a motion."""

import numpy as np
import pytest

from w2w.core.motion.source import SourceMotion, UnusableMotion, is_pose, refuse_pose


def lifting(height, n_frames=10):
    """Two bones, a metre apart, of which the second rises evenly."""
    rest = np.tile(np.eye(4), (2, 1, 1))
    rest[1, 2, 3] = 1
    matrices = np.tile(rest, (n_frames, 1, 1, 1))
    matrices[:, 1, 2, 3] += np.linspace(0, height, n_frames)
    return SourceMotion(("a", "b"), np.array([-1, 0]), rest, matrices, 30.0, "lift")


def test_what_moves_enough_for_long_enough_is_a_motion():
    refuse_pose(lifting(0.1))
    assert not is_pose(lifting(0.1))


@pytest.mark.parametrize(
    ("motion", "reason"),
    [
        (lifting(0.001), "nothing moves over the 10 frames of 'lift'"),
        (lifting(0.5, 3), "3 frames in 'lift'"),
        (lifting(0.5, 1), "1 frame in 'lift'"),
        (lifting(np.nan), "values that no body has"),
    ],
)
def test_a_pose_is_refused_with_the_reason(motion, reason):
    with pytest.raises(UnusableMotion, match=reason):
        refuse_pose(motion)
