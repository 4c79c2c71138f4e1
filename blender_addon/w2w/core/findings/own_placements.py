# SPDX-License-Identifier: GPL-3.0-or-later
"""How placements of one's own do beside the sampled patches, as plain values on file."""

from __future__ import annotations

from typing import Any

import numpy as np

from .advice_content import DIGITS, place_content
from .finished_study import Study


def own_content(study: Study) -> list[dict[str, Any]]:
    """Each placement with its scores, its rank among the sampled patches and what it loses against the best.

    Returns
    -------
    list of dict
        `rank` counts the sampled patches whose expected F1 is higher, and one; `loss` is the expected F1 that
        wearing the sensor there costs against the best patch; `as_good` says whether they can be told apart.
    """
    utility, patches = study.results.utility, study.results.patches
    known = [name.lower() for name in patches.names]
    own = [known.index(" ".join(name.lower().split())) for name, _ in study.config.placements]
    sampled = np.setdiff1d(np.arange(len(patches)), own)
    expected = utility.expected_mean
    return [
        {
            **place_content(patch, utility, patches),
            "rank": int((expected[sampled] > expected[patch]).sum()) + 1,
            "of": len(sampled) + 1,
            "loss": round(float(expected.max() - expected[patch]), DIGITS),
            "as_good": bool(utility.as_good[patch]),
        }
        for patch in own
    ]
