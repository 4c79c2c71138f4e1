# SPDX-License-Identifier: GPL-3.0-or-later
"""How cheap worn and simulated sensors may be, set by set: signals, a page and its picture."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from w2w.core.body.body import Body
from w2w.core.csv_tables import csv_text
from w2w.core.files import atomic_write, write_text
from w2w.core.imu.presets import DEFAULT_SENSOR, PRESETS
from w2w.core.imu.sensor import SensorModel
from w2w.core.keypoints.fit import fit_keypoints
from w2w.core.study.variants import ALONE, FINEST_HZ, KNOBS

from ..datasets.utd_mhad import UTD_IMU_RATE, read_utd_mhad
from ..validation.needs import APART, COUNTED, WITHIN, Curves, Side, curves, simulated, verdicts, worn
from ..validation.protocol import Protocol
from .site_simulator import SiteSimulator
from .unpaired import RegionSimulator, load_motions, real_side
from .utd import KINECT_20, POSE_CUTOFF_HZ, SITES, WINDOW

PAGE, TABLE, PICTURE = "needs.md", "losses.csv", "needs.png"

CAPTURED = "motion capture"
"""Analysis that is compared: the others are limited to the Kinect's band."""


def of_protocol(
    protocol: Protocol, path: Path, libraries: Sequence[Path], told: Callable[[str], None]
) -> list[Curves]:
    """The curves of a set that is compared with clips of other people."""
    (analysis,) = (one for one in protocol.analyses if one.name == CAPTURED)
    body, (rate, spec) = Body.bundled(), (protocol.rate_hz, protocol.windows)
    real = real_side(protocol, protocol.read(path), analysis)
    motions, _ = load_motions(protocol, libraries, body, told)
    simulator = RegionSimulator(body, replace(protocol, rate_hz=FINEST_HZ, sensor=SensorModel.ideal()))
    made = simulator.side(motions, analysis)
    sides = (
        Side(real.recordings, worn(protocol.sensor, rate, spec), protocol.worn_site_of),
        Side(made.recordings, simulated(protocol.sensor, rate, spec), simulator.site_of),
    )
    return [curves(protocol.name, tuple(protocol.sites), sides, protocol.use, analysis.activities)]


def of_utd(path: Path) -> list[Curves]:
    """The curves of UTD-MHAD, in which the same people moved: one set for each site."""
    part, found = PRESETS[DEFAULT_SENSOR], []
    trials = read_utd_mhad(path)
    for site, placement in SITES.items():
        chosen = [trial for trial in trials if trial.recording.sites == (site,)]
        simulator = SiteSimulator({site: placement}, FINEST_HZ, SensorModel.ideal())
        made = []
        for trial in chosen:
            poses = (trial.skeleton, trial.skeleton_rate, KINECT_20, simulator.body, "y", POSE_CUTOFF_HZ)
            real = trial.recording
            made.append(
                simulator.record(
                    fit_keypoints(*poses).motion.labelled(real.activity, real.subject, real.clip)
                )
            )
        recordings = [trial.recording for trial in chosen]
        sides = (
            Side(recordings, worn(part, UTD_IMU_RATE, WINDOW), None),
            Side(made, simulated(part, UTD_IMU_RATE, WINDOW), None),
        )
        activities = tuple(dict.fromkeys(one.activity for one in recordings))
        found.append(curves(f"UTD-MHAD, {site}", (site,), sides, "both", activities))
    return found


def write_needs(out: Path, sets: Sequence[Curves]) -> str:
    """Write page, table and picture; returns the page."""
    write_text(out / TABLE, csv_text(_rows(sets)))
    _picture(out / PICTURE, sets)
    lines = ["# How cheap may the sensor be: worn against simulated", ""]
    lines += [
        "| rule | sites and parameters | within one step | the same | losses apart |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {one.rule} | {one.cases} | {one.within:.0%} | {one.same:.0%} | {one.apart:.3f} |"
        for one in verdicts(sets)
    ]
    lines += ["", f"Required: within one step at {WITHIN:.0%}, and losses at most {APART:.2f} apart.", ""]
    lines += [f"![Losses, worn and simulated]({PICTURE})", "", *_cheapest(sets)]
    text = "\n".join([*lines, ""])
    write_text(out / PAGE, text)
    return text


def _cheapest(sets: Sequence[Curves]) -> list[str]:
    """The cheapest values by set and site, worn and simulated."""
    knobs = [*COUNTED]
    lines = [
        f"| set, site | F1 | {' | '.join(knobs)} | no gyroscope |",
        "|---|---|---|" + "---|" * len(knobs),
    ]
    for one in sets:
        for number, site in enumerate(one.sites):
            cells = [f"{one.f1[0, number]:.2f}, {one.f1[1, number]:.2f}"]
            for knob in knobs:
                names = ["as it is", *(one.tried[row].name for row in one.rows(knob))]
                steps = one.steps(knob)[:, number] if one.rows(knob) else []
                cells.append(", ".join(names[step] for step in steps))
            alone = [one.loss[:, row, number] for row in one.rows(ALONE)]
            cells.append("".join(f"{worn_loss:.2f}, {made_loss:.2f}" for worn_loss, made_loss in alone))
            lines.append(f"| {one.name}, {site} | {' | '.join(cells)} |")
    said = "F1 with the part as it is, cheapest values, F1 lost without the gyroscope"
    return [*lines, "", f"In each cell worn, then simulated: {said}."]


def _rows(sets: Sequence[Curves]) -> list[list[object]]:
    rows: list[list[object]] = [
        [
            "set",
            "site",
            "parameter",
            "value",
            *(f"{side}{end}" for side in SIDES for end in ("", "_low", "_high")),
        ]
    ]
    for one in sets:
        for v, variant in enumerate(one.tried):
            for s, site in enumerate(one.sites):
                cells = [f"{each[k, v, s]:.4f}" for k in (0, 1) for each in (one.loss, one.low, one.high)]
                rows.append([one.name, site, variant.knob, variant.name, *cells])
    return rows


SIDES = ("worn", "simulated")


def _picture(path: Path, sets: Sequence[Curves]) -> None:
    """Losses against the value, a row a set and a column a parameter, worn and simulated, mean over sites."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from w2w.drawing.page import ACCENT, DPI, FAINT, INK  # matplotlib is slow to import

    figure = Figure(figsize=(9.5, 1.9 * len(sets) + 0.6), dpi=DPI, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(len(sets), len(COUNTED), squeeze=False, sharey="row")
    for row, one in zip(grid, sets, strict=True):
        for axes, knob in zip(row, COUNTED, strict=True):
            numbers = one.rows(knob)
            axes.set_visible(bool(numbers))
            names = ["as it is", *(KNOBS[knob].text(one.tried[number].value) for number in numbers)]
            for side, (name, colour) in enumerate(zip(SIDES, (INK, ACCENT), strict=True)):
                loss = np.vstack([np.zeros(len(one.sites)), one.loss[side, numbers]])
                axes.plot(loss, color=colour, linewidth=0.7, alpha=0.35)
                axes.plot(loss.mean(axis=1), color=colour, linewidth=2, label=name)
            axes.axhline(0.02, color=FAINT, linewidth=0.8, linestyle=":")
            axes.set_xticks(range(len(names)), names, fontsize=7.5)
            axes.tick_params(axis="y", labelsize=7.5)
            axes.set_title(f"{one.name}: {knob}", fontsize=9, color=INK, loc="left")
    grid[0, 0].set_ylabel("F1 lost", fontsize=8.5)
    grid[0, 0].legend(fontsize=8, frameon=False)
    with atomic_write(path) as stream:
        figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
