# SPDX-License-Identifier: GPL-3.0-or-later
"""How placements of one's own do beside the sampled patches, as plain values on file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..files import DIGITS
from ..patches.patches import PatchSet
from ..ranking.utility import UtilityMap
from ..wording import plain_words
from .advice_content import patch_content
from .finished_study import Study


def own_content(study: Study) -> list[dict[str, Any]]:
    """Each placement of a finished study with its scores: see `own_scores`."""
    names = [name for name, _ in study.config.placements]
    return own_scores(names, study.results.utility, study.results.patches)


def own_scores(names: Sequence[str], utility: UtilityMap, patches: PatchSet) -> list[dict[str, Any]]:
    """Each placement with its scores, its rank among the sampled patches and what it loses against the best.

    Parameters
    ----------
    names : sequence of str
        Of the placements among the patches.
    utility : UtilityMap
    patches : PatchSet

    Returns
    -------
    list of dict
        `rank` counts the sampled patches whose expected F1 is higher, and one; `loss` is the expected F1 that
        wearing the sensor there costs against the best patch; `as_good` says whether they can be told apart.
    """
    known = [name.lower() for name in patches.names]
    own = [known.index(plain_words(name)) for name in names]
    sampled = np.setdiff1d(np.arange(len(patches)), own)
    expected = utility.expected_mean
    return [
        {
            **patch_content(patch, utility, patches),
            "rank": int((expected[sampled] > expected[patch]).sum()) + 1,
            "of": len(sampled) + 1,
            "loss": round(float(expected.max() - expected[patch]), DIGITS),
            "as_good": bool(utility.as_good[patch]),
        }
        for patch in own
    ]
