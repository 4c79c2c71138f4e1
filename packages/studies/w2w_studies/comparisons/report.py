# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a validation down: tables, pictures, one honest sentence."""

from pathlib import Path
from typing import Any

import numpy as np

from w2w.core.csv_tables import apart, csv_text
from w2w.core.files import DIGITS, json_number, write_json, write_text
from w2w.core.ranking.agreement import Agreement
from w2w.core.study.config import plain

from ..validation.protocol import Found
from ..validation.regret import Regret
from ..validation.site_scores import SiteScores
from ..validation.sites import Estimate, SiteValidation


def write_validation(out: Path, one: Found, title: str) -> str:
    """Write ``report.md``, ``f1.csv``, ``validation.json`` and two pictures; returns the report."""
    from .figures import score_maps_figure, site_bars_figure  # matplotlib is slow to import

    out.mkdir(parents=True, exist_ok=True)
    found, suffix = one.validation, one.suffix
    score_maps_figure(out / f"f1_maps{suffix}.png", found, title)
    site_bars_figure(out / f"f1_sites{suffix}.png", found, title)
    write_text(out / f"f1{suffix}.csv", _f1_table(found))
    write_json(out / f"validation{suffix}.json", _content(one, title))
    text = _report(one, title)
    write_text(out / f"report{suffix}.md", text)
    return text


def agreement_table(found: SiteValidation) -> list[str]:
    """Markdown lines: rho, its interval, tau and p by activity, then of the mean F1."""
    lines = [
        "| activity | rho | 95 % interval | tau | p | best real | best simulated |",
        "|---|---|---|---|---|---|---|",
    ]
    rows = [
        (name.replace("_", " "), found.by_activity[name], found.real.f1[:, c], found.simulated.f1[:, c])
        for c, name in enumerate(found.real.activities)
    ]
    rows.append(("**mean F1**", found.overall, found.real.mean, found.simulated.mean))
    for name, agreement, real, simulated in rows:
        best = [found.sites[int(scores.argmax())] for scores in (real, simulated)]
        lines.append(f"| {name} | {_numbers(agreement)} | {best[0]} | {best[1]} |")
    lines.append(
        f"| **mean of rho** | {found.mean_rho:.2f} | {found.mean_low:.2f} to {found.mean_high:.2f} | "
        f"| {found.mean_p:.3f} | | |"
    )
    return lines


def _numbers(agreement: Agreement) -> str:
    if agreement.spearman != agreement.spearman:
        return "no ranking | | | "
    return (
        f"{agreement.spearman:.2f} | {agreement.low:.2f} to {agreement.high:.2f} | {agreement.kendall:.2f} "
        f"| {agreement.p_value:.3f}"
    )


def _report(one: Found, title: str) -> str:
    found, suffix = one.validation, one.suffix
    lines = [
        f"# {title}",
        "",
        found.sentence(),
        "",
        found.regret_sentence(),
        found.level_sentence(),
        "",
        *(f"- {note}" for note in one.notes),
    ]
    sites = ", ".join(f"{site} ({patch})" for site, patch in zip(found.sites, one.simulated_at, strict=True))
    lines += [f"- Sites: {sites}.", f"- Real: {_side(found.real)}. Simulated: {_side(found.simulated)}."]
    for side, utility in (("real", found.real), ("simulated", found.simulated)):
        lines += [f"- Left out ({side}): {reason}." for reason in utility.left_out.values()]
    lines += ["", *agreement_table(found), ""]
    lines += [f"![F1 by activity and site](f1_maps{suffix}.png)", ""]
    lines += [f"![F1 site by site, real and simulated](f1_sites{suffix}.png)", ""]
    return "\n".join(lines)


def _side(scores: SiteScores) -> str:
    return f"{scores.n_clips} clips, {scores.n_windows} test windows, {scores.classifier}, {scores.protocol}"


def _f1_table(found: SiteValidation) -> str:
    lines = [["side", "site", "activity", "f1", "low", "high"]]
    for side, scores in (("real", found.real), ("simulated", found.simulated)):
        table = np.stack([scores.f1, *scores.f1_interval], axis=-1)
        means = np.stack([scores.mean, *scores.mean_interval], axis=-1)
        names = (*apart(scores.activities, ["mean"]), "mean")
        for row, site in enumerate(found.sites):
            for activity, cells in zip(names, (*table[row], means[row]), strict=True):
                lines.append([side, site, activity, *(f"{value:.{DIGITS}f}" for value in cells)])
    return csv_text(lines)


def _content(one: Found, title: str) -> dict[str, Any]:
    found = one.validation
    return {
        "title": title,
        "sentence": found.sentence(),
        "notes": one.notes,
        "sites": dict(zip(found.sites, one.simulated_at, strict=True)),
        "rho_mean": json_number(found.mean_rho),
        "rho_mean_interval": [json_number(found.mean_low), json_number(found.mean_high)],
        "rho_mean_p": json_number(found.mean_p),
        "rho_of_as_many_others": _estimate(found.ceiling),
        "rho_of_mean_f1_of_as_many_others": _estimate(found.overall_ceiling),
        "r_over_cells": _estimate(found.cells),
        "r_over_cells_at_most": json_number(found.cells_ceiling),
        "simulated_above_real": _estimate(found.level),
        "regret": _regret(found.regret),
        "regret_by_activity": _regret(found.regret_by_activity),
        "by_activity": {name: _agreement(value) for name, value in found.by_activity.items()},
        "mean_f1": _agreement(found.overall),
    }


def _agreement(agreement: Agreement) -> dict[str, Any]:
    return {
        name: json_number(value) if isinstance(value, float) else value
        for name, value in plain(agreement).items()
    }


def _estimate(found: Estimate) -> dict[str, Any]:
    return {"value": json_number(found.value), "interval": [json_number(found.low), json_number(found.high)]}


def _regret(found: Regret) -> dict[str, Any]:
    return {
        "lost": json_number(found.lost),
        "interval": [json_number(found.low), json_number(found.high)],
        "at_random": json_number(found.at_random),
    }
