# SPDX-License-Identifier: GPL-3.0-or-later
"""How far the maps of several bodies agree, as a file."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

from w2w.core.files import json_number, write_json
from w2w.core.findings.advice_content import patch_content
from w2w.core.findings.finished_study import Study
from w2w.core.ranking.agreement import rank_agreement

from ..runs.own_files import claimed

COMPARISON = "bodies.json"


def write_comparison(studies: Sequence[tuple[str, Study]], out: Path) -> dict[str, Any]:
    """Write and return `bodies.json`: each body's best spot and set to wear, and how far their maps agree."""
    content = {
        "bodies": {
            name: {
                "body": study.body.name,
                "height_m": round(study.body.height, 3),
                "best_single_patch": patch_content(
                    study.advice.best, study.results.utility, study.results.patches
                ),
                "worn_together": _worn(study),
            }
            for name, study in studies
        },
        "agreement": [
            {"bodies": [first, second], **_agreement(a, b)}
            for (first, a), (second, b) in combinations(studies, 2)
        ],
    }
    with claimed(out, [COMPARISON]):
        write_json(out / COMPARISON, content)
    return content


def _worn(study: Study) -> list[str] | None:
    worn = study.advice.worn
    return None if worn is None else [study.results.patches.names[patch] for patch in worn.order]


def _agreement(first: Study, second: Study) -> dict[str, Any]:
    """Spearman's rho of two maps over the same patches, of the mean and by activity."""
    a, b = first.results.utility, second.results.utility
    mean = rank_agreement(a.mean, b.mean, a.mean_samples, b.mean_samples)
    shared = [name for name in a.activities if name in b.activities]
    by_activity = {
        name: rank_agreement(a.f1[:, a.activities.index(name)], b.f1[:, b.activities.index(name)]).spearman
        for name in shared
    }
    return {
        "spearman_mean": json_number(mean.spearman),
        "interval": [json_number(mean.low), json_number(mean.high)],
        "spearman_by_activity": {name: json_number(value) for name, value in by_activity.items()},
    }
