# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's sets of a study: the optimum beside the greedy set, and the joint test."""

import numpy as np

from w2w_studies.paper.sets import PaperSets
from w2w_studies.paper.subsets import exact_subset, greedy_subset


def sets_of(f1, target, cost=None):
    return PaperSets(greedy_subset(f1, target, cost=cost), exact_subset(f1, target, cost=cost), [], 1)


def test_the_gap_is_said_in_words():
    f1 = np.array([[1.0, 0.1], [0.1, 1.0], [0.9, 0.9]])
    sets = sets_of(f1, 0.97, np.array([4.0, 4.0, 1.0]))  # greedy takes what is cheap and says little first
    assert sets.gap_sentence() == (
        "the exact optimum reaches 1.000 with 2 sensors at a cost of 8, greedy needs 3 sensors at a cost of 9"
    )
    assert sets_of(f1, 0.9).gap_sentence() == "greedy is as good as the exact optimum"
    assert PaperSets(sets.greedy, None, [], 1).gap_sentence() == "the exact optimum was not found in time"
    assert sets.joint() is None
