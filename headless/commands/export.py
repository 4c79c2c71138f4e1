# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w export`: a finished run's signals in the form that other tools read."""

from collections.abc import Callable
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from w2w.core.exports import arrays, bids, biomechanics, parquet, pose_packs
from w2w.core.exports.study_signals import ALL, StudySignals, placed, worn
from w2w.core.results_folder import StudyResults
from w2w.core.wording import capital, shown

from ..console import NOTHING_TO_DO, USAGE, ending
from ..options import argument, chosen_sensor, option, words
from ..runs.own_files import check_whole, published

WINDOWED = {"aeon": arrays.write_arrays, "torch": arrays.write_torch, "parquet": parquet.write_parquet}
RECORDED = {"bids": bids.write_bids}
WORN = ("opensim", "xsens")
TOOLS = (*WINDOWED, *pose_packs.METHODS, *RECORDED, *WORN)


def export(
    results: argument(Path, "RESULTS", "Results folder of a finished run."),
    tool: option(str, f"Who reads it: {', '.join(TOOLS)}.", "--for"),
    out: option(
        Path | None, "New folder.  [default: export/TOOL in RESULTS]", "--out", "-o", show_default=False
    ) = None,
    places: option(
        str,
        "Sensors, comma-separated: 'left wrist, sternum', a patch's name, 'all'; for pose "
        "estimators, opensim and xsens also numbers of the body's vertices.  [default: those the run "
        "chose; for pose estimators the method's own]",
    ) = "",
    sensor: option(
        str, "For pose estimators, opensim and xsens: another sensor, such as 'ideal'.  [default: the run's]"
    ) = "",
) -> None:
    """Write a finished run's signals for another tool: arrays, training data, BIDS, OpenSim, Xsens, Parquet.

    Exit codes: 0 written, 1 it cannot be (and why), 2 wrong use, 130 stopped by Ctrl-C.
    """
    console = Console(highlight=False)
    with ending(USAGE, console):
        if tool not in TOOLS:
            raise ValueError(f"--for must be one of {', '.join(TOOLS)}, not {tool}")
        study = StudyResults.load(results)
        target = out or results / "export" / tool
        say = lambda text: console.print(f"{capital(text)}.", markup=False)  # noqa: E731
        write = _writer(study, tool, places, sensor, say)
        check_whole(target)
    with (
        ending(NOTHING_TO_DO, console, "Nothing written: "),
        console.status(f"Writing {tool}"),
        published(target) as folder,
    ):
        said = write(folder)
    console.print(f"{said}: {escape(shown(target))}")


def _writer(
    study: StudyResults, tool: str, places: str, sensor: str, say: Callable[[str], None]
) -> Callable[[Path], str]:
    """The function that fills a folder and says what it wrote; wrong arguments are found before it runs."""
    config = study.config()
    if tool in WINDOWED or tool in RECORDED:
        if sensor:
            raise ValueError(f"--for {tool} writes the run's own signals: give the sensor to `w2w run`")
        signals = StudySignals.at(study, places, say)
        kind = "windows" if tool in WINDOWED else "clips"
        write = {**WINDOWED, **RECORDED}[tool]
        return lambda folder: f"{write(folder, signals)} {kind} of {_listed(signals.names)}"
    model = chosen_sensor(sensor) if sensor else config.sensor_model()
    given = list(study.patches.names if places.strip().lower() == ALL else words(places))
    if tool in pose_packs.METHODS:
        patches = placed(study, given or pose_packs.sites_of(tool))
        clips = worn(study, patches, pose_packs.RATE_HZ, model)

        def write_pack(folder: Path) -> str:
            gravity = config.synthesis.gravity
            count = pose_packs.write_pose_pack(folder, tool, study.body(), patches, clips, gravity)
            return f"{count} clips of {_listed(patches.names)} at {pose_packs.RATE_HZ:g} Hz"

        return write_pack
    patches = placed(study, given or list(StudySignals.at(study, "").names))
    clips = worn(study, patches, config.synthesis.rate_hz, model)
    if tool == "opensim":
        return lambda folder: (
            f"{biomechanics.write_opensim(folder, study.body(), clips)} clips of {_listed(patches.names)}"
        )
    return lambda folder: f"{biomechanics.write_xsens(folder, clips)} clips of {_listed(patches.names)}"


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(names) if len(names) <= 6 else f"{len(names)} sensors"
