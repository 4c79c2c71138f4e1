# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study pilot`: does F1 worn at one site say what people reach at the others, by rules fixed first."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console

from w2w.headless.console import USAGE, ending

from ..comparisons.pilot import PARTS, WAYS, Simulated, simulated_f1, worn_f1
from ..comparisons.pilot_rules import (
    Case,
    by_activity_errors,
    by_distance_errors,
    cases,
    errors,
    frozen,
    mean_abs,
    no_pilot,
    regrets,
    rules,
)  # fmt: skip
from ..comparisons.truth import DATA_SETS
from .consoles import wide_console


def pilot(
    libraries: Annotated[
        list[Path],
        typer.Argument(metavar="LIBRARY...", help="Folders of motion files, and UTD-MHAD's folder or npz."),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder of F1 that is found once and kept.")],
    part: Annotated[str, typer.Option(help=f"Half of the people: {' or '.join(PARTS)}.")] = PARTS[0],
    mhad: Annotated[Path | None, typer.Option(help="npz of Berkeley MHAD's accelerometers.")] = None,
    umafall: Annotated[Path | None, typer.Option(help="npz of UMAFall.")] = None,
    dsads: Annotated[Path | None, typer.Option(help="DSADS's folder, or an npz of it.")] = None,
    upfall: Annotated[Path | None, typer.Option(help="UP-Fall's CompleteDataSet.csv, or its trials.")] = None,
) -> None:
    """Predict worn F1 at each site from F1 at others, by every rule of docs/evidence/pilot.md.

    What is kept in the folder is not found again.

    Exit codes: 0 done, 2 wrong use.
    """
    console, given = wide_console(), {"mhad": mhad, "umafall": umafall, "dsads": dsads, "upfall": upfall}
    with ending(USAGE, console):
        if part not in PARTS or not any(given.values()):
            raise ValueError(f"--part is {' or '.join(PARTS)}, and a data set is needed at least")
        out.mkdir(parents=True, exist_ok=True)
        found: dict[str, list[Case]] = {}
        chance = {}
        for name, path in given.items():
            if path is None:
                continue
            protocol = DATA_SETS[name]
            made: Simulated = simulated_f1(protocol, libraries, out / f"simulated_{name}.npz", console.print)
            worn = worn_f1(
                protocol, path, part, protocol.analyses[0].activities, out / f"worn_{name}_{part}.npz"
            )
            found[protocol.name] = cases(made, worn)
            chance[protocol.name] = float(np.nanmean(worn.chance)), 1 / len(worn.activities)
        _table(found, console)
        for name, (reached, even) in chance.items():
            console.print(f"{name}: labels by chance give {reached:.2f}; one of its activities is {even:.2f}")


def _table(found: dict[str, list[Case]], console: Console) -> None:
    """Print the mean absolute error of each rule, by set, the mean over both ways."""

    def row(name: str, of: dict[str, list[float]], text: str = "") -> None:
        means = {set_name: float(np.nanmean(values)) for set_name, values in of.items()}
        shown = " | ".join(f"{value:.3f}" for value in means.values())
        console.print(f"| {name} | {np.nanmean([*means.values()]):.3f} | {shown} |{text}")

    console.print(f"| rule | mean | {' | '.join(found)} |")
    for name, rule in rules().items():
        row(name, {s: [mean_abs([errors(c, rule)]) for c in both] for s, both in found.items()})
        lost = np.mean([regrets(c, rule).mean() for both in found.values() for c in both])
        console.print(f"  regret {lost:.3f}")
    own = {s: [(c.w - c.e).mean(axis=1) for c in both] for s, both in found.items()}
    row("worn less expected F1, mean of the sites", {s: [float(d.mean()) for d in v] for s, v in own.items()})
    row("  its spread between sites", {s: [float(d.std(ddof=1)) for d in v] for s, v in own.items()})
    for length in (0.2, 0.4, 0.8):
        for sites in (2, 3):
            row(
                f"by distance {length}, {sites} sites",
                {
                    s: [mean_abs([by_distance_errors(c, sites, length)]) for c in both]
                    for s, both in found.items()
                },
            )
    for m in (0.0, 0.25, 0.5, 0.75, 1.0):
        rule = rules()["shrunk shift 0.8"]
        row(
            f"each activity, shrunk shift 0.8, own {m}",
            {s: [mean_abs([by_activity_errors(c, rule, m)]) for c in both] for s, both in found.items()},
        )
    for sites in (1, 2, 3):
        for people in (None, 2, 3):
            held = {s: [frozen(c, sites, people) for c in both] for s, both in found.items()}
            what = f"{people} people" if people else "everyone"
            row(
                f"frozen, {sites} sites, {what}",
                {s: [mean_abs([h.errors]) for h in v] for s, v in held.items()},
            )
            of = {s: [float(np.mean(h.inside)) for h in v] for s, v in held.items()}
            row(f"  its 90 % intervals hold, {WAYS[0]} and {WAYS[1]}", of)
            if people is None:
                row("  each activity", {s: [mean_abs([h.by_activity]) for h in v] for s, v in held.items()})
    for sites, people in ((1, 2), (1, 3)):
        row(
            f"no pilot, where {people} people can be tested",
            {s: [mean_abs([errors(c, no_pilot, sites, people)]) for c in both] for s, both in found.items()},
        )
