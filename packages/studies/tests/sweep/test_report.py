# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sweep says of how far a map repeats."""

from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from w2w.core.body.body import Body
from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w.core.study.config import StudyConfig
from w2w_studies.sweep.cases import Case
from w2w_studies.sweep.report import SweptCase, show_sweep
from w2w_studies.sweep.sensitivity import compare_maps


@pytest.fixture(scope="module")
def usual():
    rng = np.random.default_rng(0)
    activity = np.repeat(["bow", "jump"], 36)
    clip = np.arange(72) // 3
    features = rng.normal(size=(72, 6, 4)) + (activity == "bow")[:, None, None] * np.arange(6)[:, None] / 3
    everything = np.ones(72, bool)
    return utility_map(
        features.astype(np.float32),
        CrossValidation(activity, clip, None, everything, ("bow", "jump")),
        Ridge(alphas=(0.1,)),
        resamples=100,
    )


def said(utility):
    console = Console(record=True, width=1000, file=StringIO())
    one = SweptCase(Case("usual", "as run", StudyConfig()), utility, compare_maps(utility, utility))
    show_sweep([one], sample_patches(Body.bundled(), 6), console)
    return console.export_text()


def test_resampled_clips_do_not_pass_for_other_clips(usual):
    text = said(usual)
    assert "These very clips resampled agree by a rho of" in text
    halves = usual.reliability / (2 - usual.reliability)
    assert f"disjoint halves of them, whose maps are pooled over the skin, by {halves:.2f}" in text
