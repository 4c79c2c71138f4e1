# SPDX-License-Identifier: GPL-3.0-or-later
"""Write `assets/templates/patch_order.npy`: in which order vertices of the bundled body become patches.

Farthest-point sampling by exact geodesic distances, which takes minutes. Run it as
`python tools/make_patch_order.py`.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from pygeodesic.geodesic import PyGeodesicAlgorithmExact

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from w2w.core.body.body import Body
from w2w.core.patches.patches import PATCH_ORDER, TIE


def main() -> None:
    body = Body.bundled()
    exact = PyGeodesicAlgorithmExact(body.vertices, body.faces)
    picks, distance = [], np.full(len(body.vertices), np.inf)
    pick = int(np.random.default_rng(0).integers(len(body.vertices)))
    while len(picks) < len(body.vertices):
        picks.append(pick)
        distance = np.minimum(distance, exact.geodesicDistances([pick], None)[0])
        distance[picks] = -np.inf  # rounding may leave a picked vertex a hair's breadth from itself
        pick = int(np.argmax(distance >= distance.max() - TIE))
    np.save(PATCH_ORDER, np.array(picks, dtype=np.int16))


if __name__ == "__main__":
    main()
