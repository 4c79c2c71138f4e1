"""A motion at another rate keeps its poses at the times that both rates share."""

import numpy as np

from w2w.core.motion.motion import at_rate


def test_frames_that_both_rates_share_stay(waving):
    fine = at_rate(waving, 90.0)
    np.testing.assert_allclose(fine.rotations[::3], waving.rotations, atol=1e-9)
    np.testing.assert_allclose(fine.pelvis[::3], waving.pelvis, atol=1e-9)
    assert fine.duration == waving.duration


def test_the_same_rate_is_the_same_motion(waving):
    assert at_rate(waving, waving.rate) is waving
