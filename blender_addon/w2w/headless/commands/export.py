# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w export`: a finished run's signals in the form that other tools read."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from ...core.exports import arrays, bids, biomechanics, pose_packs
from ...core.exports.study_signals import ALL, StudySignals, WornSignals, placed
from ...core.given import inside
from ...core.study.results import StudyResults
from ...core.wording import capital, clean
from ..console import NOTHING_TO_DO, USAGE, console_beside, ending, print_json
from ..options import AsJson, argument, chosen_sensor, option, words
from ..runs.own_files import check_whole, published

WRITERS: dict[str, Callable[[Path, Any], int]] = {
    "aeon": arrays.write_arrays,
    "torch": arrays.write_torch,
    "parquet": arrays.write_parquet,
    **{method: partial(pose_packs.write_pose_pack, method=method) for method in pose_packs.METHODS},
    "bids": bids.write_bids,
    "opensim": biomechanics.write_opensim,
    "xsens": biomechanics.write_xsens,
}
WINDOWED = ("aeon", "torch", "parquet")


def export(
    results: Annotated[Path, argument("RESULTS", "Results folder of a finished run.")],
    tool: Annotated[str, option(f"Who reads it: {', '.join(WRITERS)}.", "--for")],
    out: Annotated[
        Path | None,
        option("New folder.  [default: export/TOOL in RESULTS]", "--out", "-o", show_default=False),
    ] = None,
    places: Annotated[
        str,
        option(
            "Sensors, comma-separated: 'left wrist, sternum', a patch's name, 'all'; for pose "
            "estimators, opensim and xsens also numbers of the body's vertices.  [default: those the run "
            "chose; for pose estimators the method's own]"
        ),
    ] = "",
    sensor: Annotated[
        str,
        option(
            "For pose estimators, opensim and xsens: another sensor, such as 'ideal'.  [default: the run's]"
        ),
    ] = "",
    as_json: AsJson = False,
) -> None:
    """Write a finished run's signals for another tool: arrays, training data, BIDS, OpenSim, Xsens, Parquet.

    Exit codes: 0 written, 1 it cannot be (and why), 2 wrong use, 4 the run in RESULTS is unfinished,
    130 stopped by Ctrl-C.
    """
    console = console_beside(as_json)
    with ending(USAGE, console):
        if tool not in WRITERS:
            raise ValueError(f"--for must be one of {', '.join(WRITERS)}, not {tool}")
        study = StudyResults.load(results)
        target = out or inside(results, f"export/{tool}")
        signals = _signals(study, tool, places, sensor, lambda text: console.print(f"{capital(text)}."))
        check_whole(target)
    with (
        ending(NOTHING_TO_DO, console, "Nothing written: "),
        console.status(f"Writing {tool}"),
        published(target) as folder,
    ):
        count = WRITERS[tool](folder, signals)
    names = ", ".join(signals.names) if len(signals.names) <= 6 else f"{len(signals.names)} sensors"
    what = f"{count} {'windows' if tool in WINDOWED else 'clips'} of {names}"
    if tool in pose_packs.METHODS:
        what += f" at {pose_packs.RATES_HZ[tool]:g} Hz"
    if as_json:
        print_json({"tool": tool, "folder": str(target), "count": count, "sensors": list(signals.names)})
    else:
        console.print(f"{what}: {clean(target)}")


def _signals(
    study: StudyResults, tool: str, places: str, sensor: str, say: Callable[[str], None]
) -> StudySignals | WornSignals:
    """The signals to write; a ValueError says which argument is wrong."""
    if tool in WINDOWED or tool == "bids":
        if sensor:
            raise ValueError(f"--for {tool} writes the run's own signals: give the sensor to `w2w run`")
        return StudySignals.at(study, places, say)
    config = study.config()
    model = chosen_sensor(sensor) if sensor else config.sensor_model()
    given = list(study.patches.names if places.strip().lower() == ALL else words(places))
    if tool in pose_packs.METHODS:
        patches = placed(study, given or pose_packs.sites_of(tool))
        return WornSignals(study, patches, pose_packs.RATES_HZ[tool], model)
    patches = placed(study, given or list(StudySignals.at(study, "", say).names))
    return WornSignals(study, patches, config.synthesis.rate_hz, model)
