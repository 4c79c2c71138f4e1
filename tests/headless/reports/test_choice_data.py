# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's page gets the F1 to the bit, and the patches that words mean as the command line has them."""

import base64

import numpy as np

from w2w.core.patches.body_parts import find_patches
from w2w.core.results_folder import StudyResults
from w2w.headless.reports.choice_data import choice_data, words_of


def test_scores_come_to_the_bit(drawn_results):
    study = StudyResults.load(drawn_results)
    found = choice_data(study.utility, study.patches, 0.9, None)
    f1 = np.frombuffer(base64.b64decode(found["f1"]["data"]), "<f4")
    np.testing.assert_array_equal(f1.reshape(study.utility.f1.shape), study.utility.f1)
    assert (found["target"], found["most"]) == (0.9, "")


def test_words_mean_what_they_mean_elsewhere(drawn_results):
    patches = StudyResults.load(drawn_results).patches
    words = words_of(patches)
    for word, places in words.items():
        assert places == sorted(set(find_patches(patches.regions, patches.names, word).tolist())), word
    assert {"left", "middle", "head", "right leg", "torso"} <= set(words)
    assert all(places for places in words.values())
    assert set().union(*words.values()) == set(range(len(patches)))
