# SPDX-License-Identifier: GPL-3.0-or-later
"""Of four intervals of rho, ours holds the truth about as often as it says."""

import numpy as np

from w2w.studies.experiments.rho_intervals import coverage


def test_few_sites_need_more_than_the_bias_corrected_interval():
    percentile, corrected, bca, stated = coverage(5, 0.6, np.random.default_rng(0), trials=120)
    assert stated >= max(percentile, 0.9)
    assert max(corrected, bca) < stated - 0.05
