# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished study as one page that opens in any browser, without a network."""

import base64
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined, UndefinedError
from markupsafe import Markup
from PIL import Image

from ..core.body.body import Body, first_turn
from ..core.colours import LEAST_SPAN, Scale, colour_table
from ..core.findings import notes
from ..core.findings.cautions import OPEN, Caution, below
from ..core.findings.summary import MOST_REGIONS, best_regions
from ..core.imu.presets import wearing_sentences
from ..core.motion.skinning import triangle_frames
from ..core.patches.body_parts import PRODUCT_NAMED, PRODUCTS
from ..core.patches.naming import FAR_M, nearest_patch, places_on
from ..core.patches.patches import PatchSet
from ..core.ranking.costs import costs_at, is_as_good
from ..core.ranking.utility import UtilityMap
from ..core.selection import headline
from ..core.selection.advice import Advice
from ..core.selection.scored import product_places
from ..core.study.clip_files import is_used, read_clip_list
from ..core.study.config import StudyConfig
from ..core.study.results import StudyResults
from ..core.wording import capital, restated
from ..drawing.body import BodyPictures, common_crop, size_for

PAGE = Path(__file__).resolve().parent / "templates"

NUMBERED = 3
"""Products in the first screen, numbered on the body."""

MAX_CONFUSED = 12
"""Activities up to which a table of mistakes can be read."""


def report_page(study: StudyResults, project: str | None = None) -> str:
    """The page of a finished study, as HTML, under the run's title or another.

    A ValueError says that its `summary.json` lacks what the page shows.
    """
    wrong, faults = study.out / "summary.json", (LookupError, TypeError, AttributeError, UndefinedError)
    with restated(lambda error: f"{wrong} is not as a run writes it ({error}): run the study again", faults):
        return _page(study, project)


def _page(study: StudyResults, project: str | None) -> str:
    from .page import still_picture  # Pillow is slow to import

    body, utility, summary = study.body(), study.utility, study.summary
    config = json.loads((study.out / "config.json").read_text(encoding="utf-8"))
    answer = summary["answer"]
    patch, base = answer["patch"], answer["costs_are_against"]
    worn = summary["worn_together"]
    if worn:
        named = [{**sensor, "called": sensor["product"] or sensor["name"]} for sensor in worn["places"]]
        worn = {**worn, "places": named}
    together = [sensor["patch"] for sensor in worn["places"]] if worn else []
    shown = [product["patch"] for product in answer["products"][:NUMBERED]] or [patch]
    compared = (*answer["compared_with"], answer.get("habit"))
    less = [each for each in answer["products"][NUMBERED:] if each["name"] in compared]
    allowed = study.config().constraints.terms(study.patches).allowed
    skipped = (entry for entry in read_clip_list(study.out) if not is_used(entry))
    rows = _activity_rows(utility, study.patches.names, patch)
    return (
        _environment()
        .get_template("page.html")
        .render(
            project=study.parameters.get("title", "") if project is None else project.strip(),
            summary=summary,
            cautions=below([Caution(**each) for each in summary["cautions"]]),
            config=config,
            counts=notes.counts_sentence(summary["clips"], utility),
            in_blend=len(study.clips_in_blend),
            mean_caution=headline.mean_caution(utility),
            answer=answer,
            first_products=[*answer["products"][:NUMBERED], *less],
            still=still_picture(study, body, shown, together),
            worn=worn,
            body=body,
            on_skin=study.config().on_skin,
            wearing=wearing_sentences(study.config().sensor_model()),
            utility=utility,
            n_patches=len(study.patches),
            mean_title=headline.mean_title(utility),
            regions=best_regions(utility, study.patches, base, allowed),
            activities=[{**row, **summary["activities"][row["name"]]} for row in rows],
            by_posture="f1_by_posture" in answer,
            mistakes=_mistakes(utility, patch),
            skipped=sorted((entry["file"], entry["skipped"]) for entry in skipped),
            style=_style(),
            scripts=[Markup((PAGE / name).read_text(encoding="utf-8")) for name in ("viewer.js", "page.js")],
            data=Markup(as_script_json(view_data(body, study.patches, utility, shown, base))),
        )
    )


def worn_page(
    utility: UtilityMap, advice: Advice, config: StudyConfig, said: Mapping[str, Any], picture: bytes | None
) -> str:
    """The page of ranked recordings of worn sensors, as HTML.

    `said` are the `head`, the `cautions` as sentences, the clips `skipped`, each with the reason, and the
    `names` of the places; `picture` is a PNG of the body with the places, if there is one.
    """
    names, worn = said["names"], advice.worn
    recommended = advice.answer.patch
    return (
        _environment()
        .get_template("worn.html")
        .render(
            **said,
            answer=advice.answer,
            utility=utility,
            config=config,
            activities=_activity_rows(utility, names, recommended),
            together=worn
            and list(zip(worn.order, worn.promise.mean, worn.promise.low, worn.promise.high, strict=True)),
            worn=worn,
            cards=advice.cards,
            mistakes=_mistakes(utility, recommended),
            mean_caution=headline.mean_caution(utility),
            picture=None if picture is None else base64.b64encode(picture).decode("ascii"),
            style=_style(),
        )
    )


def _environment() -> Environment:
    environment = Environment(loader=FileSystemLoader(PAGE), autoescape=True, undefined=StrictUndefined)
    environment.globals["open_cautions"] = OPEN
    environment.filters |= {"f1": "{:.2f}".format, "title": title, "capital": capital}
    return environment


def _style() -> Markup:
    return Markup((PAGE / "style.css").read_text(encoding="utf-8"))


def _activity_rows(utility: UtilityMap, names: Sequence[str], best: int) -> list[dict[str, Any]]:
    tested, spots = utility.tested_clips(), utility.expected_f1.argmax(axis=0).tolist()
    return [
        {
            "name": name,
            "where": names[own],
            "patch": own,
            "expected": float(utility.expected_f1[own, number]),
            "f1": float(utility.f1[own, number]),
            "low": float(utility.f1_low[own, number]),
            "high": float(utility.f1_high[own, number]),
            "tested": tested[number],
            "caution": notes.few_clips(tested[number]),
            "at_best": float(utility.expected_f1[best, number]),
            "posture": None if utility.posture is None else float(utility.posture[best, number]),
            "counts": bool(utility.counts[number]),
        }
        for number, (name, own) in enumerate(zip(utility.activities, spots, strict=True))
    ]


def _mistakes(utility: UtilityMap, patch: int) -> list[dict[str, Any]]:
    """Rows of the confusion table of one patch, each window count with its share of the row."""
    if len(utility.activities) > MAX_CONFUSED:
        return []
    return [
        {"name": name, "cells": [(int(count), float(count / max(row.sum(), 1))) for count in row]}
        for name, row in zip(utility.activities, utility.confusion[patch], strict=True)
    ]


def view_data(
    body: Body, patches: PatchSet, utility: UtilityMap, chosen: list[int], base: list[int]
) -> dict[str, Any]:
    """The data of the 3D view, as plain values and `packed` arrays.

    `chosen` are the patches that carry a number, in its order, `base` those that the recommended sensor moves
    over. Map 0 is the mean over activities, then there is one for each activity: of the expected F1, which
    has an interval for the mean alone, and of the raw F1 with its interval.
    """
    corner = body.vertices.min(axis=0)
    step = float(np.ptp(body.vertices, axis=0).max()) / 65535
    spread = patches.interpolation.tocsr()
    regions = sorted(set(patches.regions))
    expected = np.column_stack([utility.expected_mean, utility.expected_f1]).T
    raw = np.column_stack([utility.mean, utility.f1]).T
    low = np.column_stack([utility.mean_low, utility.f1_low]).T
    high = np.column_stack([utility.mean_high, utility.f1_high]).T
    return {
        "titles": [headline.mean_title(utility), *(title(name) for name in utility.activities)],
        "level": utility.level,
        "cautions": [headline.mean_caution(utility), *map(notes.few_clips, utility.tested_clips())],
        "regions_listed": MOST_REGIONS,
        "colour_span": LEAST_SPAN,
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
        "as_good": packed(is_as_good(costs_at(utility, base))),
        "raw": packed(_steps(raw)),
        "low": packed(_steps(low)),
        "high": packed(_steps(high)),
        "rank": packed(np.column_stack([utility.rank_low, utility.rank_high])),
        "chosen": chosen,
        "words": _words(body, patches),
        "products": list(PRODUCTS),
        "base_f1": float(utility.expected_mean[base].mean()),
        "best": base[0],
        "turn": first_turn(body, int(patches.vertices[base[0]])),
        "colours": packed(np.rint(255 * colour_table(steps=256))),
    }


def _words(body: Body, patches: PatchSet) -> dict[str, list[int]]:
    """Patches of each product, by all its names, and of each place by name, one per side."""
    patches_of: dict[str, list[int]] = {}
    at = product_places(patches, body)
    for word, product in PRODUCT_NAMED.items():
        there = {side: at[product.name, side] for side in product.sides if (product.name, side) in at}
        patches_of[word] = list(there.values())
        patches_of |= {f"{side} {word}": [patch] for side, patch in there.items() if side}
    own = list(map(str.lower, patches.names))
    for name, vertex in places_on(body).items():
        patch, away = nearest_patch(vertex, body, patches)
        if name in own or away <= FAR_M:
            patches_of.setdefault(name, [own.index(name) if name in own else patch])
    return patches_of


def packed(array: np.ndarray) -> dict[str, str]:
    """Non-negative integers as base64, in the smallest type that holds them."""
    array = np.asarray(array)
    largest = int(array.max(initial=0))
    kind = next(kind for kind in ("uint8", "uint16", "uint32") if largest <= np.iinfo(kind).max)
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
    """F1 in 16 bits: steps of 0.000015."""
    return np.rint(np.clip(np.nan_to_num(f1), 0, 1) * 65535)


PIXELS = 560
"""Height of the body."""

ARROW = 0.17
"""Length of the arrow along a sensor's x axis, metres; a disc hides the first third."""

COLOURS = 160
"""Palette size; makes the PNG three times smaller."""


def still_picture(study: StudyResults, body: Body, first: list[int], together: list[int]) -> dict[str, Any]:
    """Front and back, coloured by expected F1, and where numbered discs for two lists of patches belong."""
    utility, patches = study.utility, study.patches
    scale = Scale.of(utility.expected_mean)
    pictures = BodyPictures(body, size_for(body, PIXELS))
    views = pictures.coloured(scale.colours(patches, utility.expected_mean))
    top, bottom, left, right = common_crop(views)
    both = np.concatenate([view[top:bottom, left:right] for view in views], axis=1)
    stream = io.BytesIO()
    Image.fromarray(both).quantize(COLOURS, Image.Quantize.FASTOCTREE).save(stream, "PNG", optimize=True)

    def marks(chosen: list[int]) -> list[tuple[float, ...]]:
        """Where each sensor is drawn, and the tip of its arrow: x, y, x, y."""
        places = patches.vertices[chosen]
        arrows = triangle_frames(body.vertices[patches.triangles[chosen]])[:, :3, 0]
        ends = [body.vertices[places], body.vertices[places] + ARROW * arrows]
        both = zip(*(pictures.locate(end, body.vertex_normals[places]) for end in ends), strict=True)
        return [
            tuple(round(n, 1) for view, x, y in pair for n in (view * (right - left) + x - left, y - top))
            for pair in both
        ]

    named = ", ".join(f"{number}: {patches.names[patch]}" for number, patch in enumerate(first, start=1))
    return {
        "picture": f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode('ascii')}",
        "width": both.shape[1],
        "height": both.shape[0],
        "low": scale.low,
        "high": scale.high,
        "first": marks(first),
        "first_named": named,
        "set": marks(together),
    }
