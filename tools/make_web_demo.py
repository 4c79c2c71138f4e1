# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the first page's picture of the web app from the results of `w2w demo`: its body, coloured by F1.

Usage: python tools/make_web_demo.py demo_output/results
"""

import json
import sys
from pathlib import Path

import numpy as np

from w2w.core.colours import colour_table
from w2w.core.study.results import StudyResults

TARGET = Path(__file__).parents[1] / "blender_addon/w2w/web/pages/demo.json"

SHOWN = ("earbud", "watch", "chest strap", "belt clip", "shoe")
"""Products whose F1 the page shows, if the demo has them."""


def picture(results: Path) -> dict[str, object]:
    """A coarse body, a corner a patch, in cm, with the colour of each corner and the F1 of some products."""
    study = StudyResults.load(results)
    body, patches, utility = study.body(), study.patches, study.utility
    corners = np.sort(patches.labels[body.faces], axis=1)
    faces = np.unique(corners[(np.diff(corners, axis=1) > 0).all(axis=1)], axis=0)
    places = body.vertices[patches.vertices]
    outward = np.zeros_like(places)  # which way round a face is seen from outside, by the skin around
    np.add.at(
        outward, patches.labels[body.faces].ravel(), np.repeat(_normals(body.vertices, body.faces), 3, axis=0)
    )
    flipped = (_normals(places, faces) * outward[faces].sum(axis=1)).sum(axis=1) < 0
    faces[flipped] = faces[flipped][:, ::-1]
    score = utility.expected_mean
    share = (score - score.min()) / np.ptp(score)
    products = {product["name"]: product for product in study.summary["answer"]["products"]}
    return {
        "places": np.rint(100 * places).astype(int).ravel().tolist(),
        "faces": faces.ravel().tolist(),
        "share": np.rint(100 * share).astype(int).tolist(),
        "colours": np.rint(255 * colour_table(steps=11)).astype(int).tolist(),
        "sentence": study.summary["answer"]["sentence"],
        "clips": study.summary["clips"]["used"],
        "activities": [name.replace("_", " ") for name in utility.activities],
        "products": [
            {
                "name": name,
                "patch": products[name]["patch"],
                "f1": round(_f1(products[name]), 2),
            }
            for name in SHOWN
            if name in products
        ],
    }


def _f1(product: dict[str, float]) -> float:
    """The F1 that the report shows first: in a stream, where there was one."""
    return product["expected_f1"]


def _normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    first, second, third = (vertices[faces[:, corner]] for corner in range(3))
    return np.cross(second - first, third - first)


if __name__ == "__main__":
    TARGET.write_text(json.dumps(picture(Path(sys.argv[1])), separators=(",", ":")) + "\n", encoding="utf-8")
