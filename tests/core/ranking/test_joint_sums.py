# SPDX-License-Identifier: GPL-3.0-or-later
"""What trainings share, done once, gives what each training gives by itself."""

import numpy as np
import pytest

from w2w.core.ranking.joint_fit import JointFit, Training
from w2w.core.ranking.joint_sums import JointSums

N, RIDGE = 6, 0.1


@pytest.mark.parametrize("worn", [(), (3,), (3, 0), (3, 0, 4)])
def test_sums_that_trainings_share_give_what_each_training_gives(worn):
    """Real proportions: classes far apart in small features, people left out, windows all are trained on."""
    rng = np.random.default_rng(3)
    n_windows, width, people = 300, 20, 7
    labels, person = rng.integers(0, 5, n_windows), rng.integers(-1, people, n_windows)
    features = rng.normal(size=(N, n_windows, width)) @ rng.normal(size=(width, width))
    features += 30 * rng.normal(size=(N, 5, width))[:, labels]
    features[:, :, 0] = 0.7  # never varies
    features -= features.mean(axis=1, keepdims=True)
    trainings = [
        Training(np.flatnonzero(person != one), np.flatnonzero(person == one)) for one in range(people)
    ]
    features = features.astype(np.float32)
    fits = [JointFit(features, labels, training, 5, RIDGE) for training in trainings]
    sums, bases = JointSums(features, labels, fits), [fit.wear(worn) for fit in fits]
    of_worn = sums.wear(worn)
    for candidate in (1, 5):
        wanted = np.concatenate([fit.add(base, candidate) for fit, base in zip(fits, bases, strict=True)])
        found = sums.add(of_worn, candidate)
        np.testing.assert_allclose(found, wanted, atol=1e-4 * np.abs(wanted).max())
