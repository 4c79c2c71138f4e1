# SPDX-License-Identifier: GPL-3.0-or-later
"""The inverse kinematics of two bones against its definition."""

import numpy as np
from hypothesis import given, strategies as st

from w2w_studies.rehab.two_bones import reach, two_bones


@given(
    st.floats(0.2, 0.5),
    st.floats(0.2, 0.5),
    st.floats(0.05, 0.95),
    st.integers(0, 2**32 - 1),
)
def test_the_end_is_on_the_target_and_the_middle_on_the_side_of_the_pole(first, second, share, seed):
    rng = np.random.default_rng(seed)
    target, pole = rng.standard_normal((2, 1, 3))
    distance = abs(first - second) + share * (first + second - abs(first - second))
    target *= distance / np.linalg.norm(target)
    along, hinge = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    upper, lower = two_bones(target, pole, first, second, tuple(along), tuple(hinge))
    for matrices in (upper, lower):
        np.testing.assert_allclose(matrices @ matrices.transpose(0, 2, 1), np.eye(3)[None], atol=1e-9)
        np.testing.assert_allclose(np.linalg.det(matrices), 1.0, atol=1e-9)
    middle = first * upper @ along
    np.testing.assert_allclose(middle + second * lower @ along, target, atol=1e-9)
    np.testing.assert_allclose(upper @ hinge, lower @ hinge, atol=1e-9)
    across = pole - np.sum(pole * target) / np.sum(target**2) * target
    assert np.sum(middle * across) > 0


def test_the_rest_pose_needs_no_rotation():
    straight = np.array([[0.0, 0.0, -reach(0.4, 0.4, 1e-7)]])
    for matrices in two_bones(
        straight, np.array([[0.0, -1.0, 0.0]]), 0.4, 0.4, (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)
    ):
        np.testing.assert_allclose(matrices[0], np.eye(3), atol=1e-6)
