# SPDX-License-Identifier: GPL-3.0-or-later
"""Feature files of a few clips, to rank their patches by processes that read them."""

import numpy as np

from w2w.core.files import write_npz
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w.core.windows.inputs import FeatureFiles

NAMES = ("bow", "jump", "walk")


def made_patches(folder):
    """Feature files of 36 clips at 20 patches, and the labels of their windows."""
    rng = np.random.default_rng(0)
    trace = rng.normal(size=(3, 20, 6)) * np.linspace(0, 1, 20)[:, None]
    for clip in range(36):
        features = trace[clip % 3] + rng.normal(size=(4, 20, 6))
        write_npz(folder / f"{clip}.npz", {"features": features.astype(np.float32)})
    clip = np.repeat(np.arange(36), 4)
    return folder, np.array(NAMES)[clip % 3], clip


def ranked(library, spread, **more):
    """The map of what `made_patches` gave."""
    folder, activity, clip = library
    inputs = FeatureFiles([folder / f"{number}.npz" for number in range(36)])
    is_test = np.arange(len(clip)) % 2 == 0
    protocol = CrossValidation(activity, clip, None, is_test, NAMES)
    return utility_map(inputs, protocol, resamples=20, spread=spread, **more)
