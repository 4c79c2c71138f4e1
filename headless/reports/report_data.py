# SPDX-License-Identifier: GPL-3.0-or-later
"""The data of the report's 3D view, small enough to be part of the page: body, patches and scores."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np

from w2w.core.body.body import Body
from w2w.core.colours import colour_table
from w2w.core.findings.counts import few_clips
from w2w.core.findings.summary import MOST_REGIONS
from w2w.core.patches.body_parts import PRODUCT_NAMED, PRODUCTS
from w2w.core.patches.naming import resolve
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.utility import UtilityMap
from w2w.core.selection.answer import nearest
from w2w.core.selection.headline import mean_caution, mean_title
from w2w.core.wording import capital

COLOURS = 256

F1_STEPS = 65535
"""F1 is kept in 16 bits: steps of 0.000015."""


def view_data(
    body: Body, patches: PatchSet, utility: UtilityMap, chosen: list[int], best: int
) -> dict[str, Any]:
    """All that the 3D view draws, as plain values and `packed` arrays.

    `chosen` are the patches that carry a number, in its order, `best` is the recommended one. Map 0 is the
    mean over activities, then there is one for each activity: of the expected F1, which has an interval for
    the mean alone, and of the raw F1 with its interval.
    """
    corner = body.vertices.min(axis=0)
    step = float(np.ptp(body.vertices, axis=0).max()) / 65535
    spread = patches.interpolation.tocsr()
    regions = sorted(set(patches.regions))
    expected = np.column_stack([utility.expected_mean, utility.expected_f1]).T
    low, raw, high = (
        np.column_stack([whole, parts]).T
        for whole, parts in (
            (utility.mean_low, utility.f1_low),
            (utility.mean, utility.f1),
            (utility.mean_high, utility.f1_high),
        )
    )
    return {
        "titles": [mean_title(utility), *(title(name) for name in utility.activities)],
        "level": utility.level,
        "cautions": [mean_caution(utility), *(few_clips(count) for count in utility.tested_clips())],
        "regions_listed": MOST_REGIONS,
        "colour_span": utility.colour_span,
        "corner": corner.round(6).tolist(),
        "step": step,
        "positions": packed(np.rint((body.vertices - corner) / step)),
        "faces": packed(body.faces),
        "cells": packed(patches.labels),
        "spread_count": packed(np.diff(spread.indptr)),
        "spread_patch": packed(spread.indices),
        "spread_share": packed(np.rint(spread.data * 65535)),
        "centres": packed(patches.vertices),
        "names": list(patches.names),
        "regions": regions,
        "region": packed(np.searchsorted(regions, patches.regions)),
        "expected": packed(_steps(expected)),
        "expected_low": packed(_steps(utility.expected_low)),
        "expected_high": packed(_steps(utility.expected_high)),
        "as_good": packed(utility.as_good),
        "raw": packed(_steps(raw)),
        "low": packed(_steps(low)),
        "high": packed(_steps(high)),
        "rank": packed(np.column_stack([utility.rank_low, utility.rank_high])),
        "chosen": chosen,
        "words": _words(body, patches),
        "products": list(PRODUCTS),
        "best": best,
        "colours": packed(np.rint(255 * colour_table(steps=COLOURS))),
    }


def _words(body: Body, patches: PatchSet) -> dict[str, list[int]]:
    """Patches that each product, by all its names, and each region stands for, one a side."""
    found: dict[str, list[int]] = {}
    for product in PRODUCTS.values():
        near = {side: nearest(product, side, patches, body) for side in product.sides}
        there = {side: patch for side, patch in near.items() if patch is not None}
        for word in (word for word, meant in PRODUCT_NAMED.items() if meant is product):
            found[word] = list(there.values())
            found |= {f"{side} {word}": [patch] for side, patch in there.items() if side}
    for region in sorted(set(patches.regions)):
        found.setdefault(region, [resolve(region, body, patches, lambda _: None)])
    return found


def packed(array: np.ndarray, kind: str = "") -> dict[str, str]:
    """Non-negative integers as base64, in the smallest type that holds them, or in a given one."""
    array = np.asarray(array)
    largest = int(array.max(initial=0))
    kind = kind or next(kind for kind in ("uint8", "uint16", "uint32") if largest <= np.iinfo(kind).max)
    data = np.ascontiguousarray(array, dtype=np.dtype(kind).newbyteorder("<")).tobytes()
    return {"type": kind, "data": base64.b64encode(data).decode("ascii")}


def as_script_json(content: Any) -> str:
    """JSON for a ``<script>`` element: nothing in it can end the element or begin a comment."""
    text = json.dumps(content, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def title(activity: str) -> str:
    """An activity's label as people write it."""
    return capital(activity.replace("_", " ").strip())


def _steps(f1: np.ndarray) -> np.ndarray:
    return np.rint(np.clip(np.nan_to_num(f1), 0, 1) * F1_STEPS)
