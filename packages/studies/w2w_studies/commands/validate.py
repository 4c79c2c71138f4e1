# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w validate`: does the simulated map rank sites as the real sensors of a public data set do?"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from w2w.core.imu.presets import DEFAULT_SENSOR
from w2w.core.imu.recordings import Recordings
from w2w.core.ranking.utility import CLASSIFIERS, unavailable
from w2w.core.study.results import StudyResults
from w2w.core.wording import clean
from w2w.headless.commands.execute import refused
from w2w.headless.console import USAGE, ending
from w2w.headless.options import chosen_sensor
from w2w.headless.runs.monitor import RunMonitor
from w2w.headless.runs.own_files import published
from w2w.headless.study_options import declared

from ..comparisons.by_protocol import compare_worn, run_protocol
from ..comparisons.gait import compare_gait, write_gait
from ..comparisons.own import Names, against_run, own_protocol
from ..comparisons.paired import VIDIMU, mmfit as mmfit_protocol, paired_sides
from ..comparisons.protocol_report import write_protocol
from ..comparisons.report import agreement_table, write_validation
from ..comparisons.truth import DATA_SETS, against_libraries, mighar_set, write_empty_positions
from ..comparisons.utd import POSE_CUTOFF_HZ, compare_utd, write_utd
from ..datasets.mmfit import NON_ACTIVITY
from ..datasets.utd_mhad import read_utd_mhad
from ..validation.protocol import Found, Protocol
from .consoles import wide_console

VALIDATE = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode="markdown",
    help="Test on your own copy of a public data set whether simulated sensors rank sites as real ones do.",
)

Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for report.md, tables and pictures.")]
Seed = Annotated[int, typer.Option(min=0, help="Of folds, bootstrap and sensor errors.")]
Libraries = Annotated[
    list[Path],
    typer.Argument(metavar="LIBRARY...", help="Folders of motion files, and UTD-MHAD's folder or npz."),
]
Folds = Annotated[int, typer.Option(min=2, help="Folds by clip, the same for real and simulated.")]

NonActivity = Annotated[
    str,
    typer.Option(
        help=f"What is between the sets: activity (the authors' eleventh class {NON_ACTIVITY}), background "
        "(trained against, compared with nothing) or out."
    ),
]


@VALIDATE.command()
def mmfit(
    path: Annotated[Path, typer.Argument(metavar="PATH", help="MM-Fit's folder of w00 to w20.")],
    out: Out,
    non_activity: NonActivity = "activity",
    sensor: Annotated[str, declared("sensor")] = DEFAULT_SENSOR,
    classifier: Annotated[str, declared("classifier")] = "ridge",
    folds: Folds = 5,
    seed: Seed = 0,
) -> None:
    """MM-Fit: ten exercises and what is between them, 3D video pose, watches, phones and an earbud.

    Exit codes: 0 written, 2 wrong use (and why).
    """
    _compare_paired(lambda: mmfit_protocol(non_activity), path, out, sensor, classifier, folds, seed)


@VALIDATE.command()
def vidimu(
    path: Annotated[Path, typer.Argument(metavar="PATH", help="VIDIMU's folder dataset/videoandimus.")],
    out: Out,
    sensor: Annotated[str, declared("sensor")] = DEFAULT_SENSOR,
    classifier: Annotated[str, declared("classifier")] = "ridge",
    folds: Folds = 5,
    seed: Seed = 0,
) -> None:
    """VIDIMU: 13 daily activities, 3D video pose, five orientation sensors. Angular velocity only.

    Exit codes: 0 written, 2 wrong use (and why).
    """
    _compare_paired(lambda: VIDIMU, path, out, sensor, classifier, folds, seed)


@VALIDATE.command()
def own(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="Results folder of a finished run.")],
    recordings: Annotated[
        Path, typer.Argument(metavar="RECORDINGS", help="Folder of recordings, or with --as a data set.")
    ],
    out: Out,
    labels: Annotated[
        Path | None, typer.Option(help="csv of the recordings' labels, as for `w2w rank-recordings`.")
    ] = None,
    sites: Annotated[
        Path | None, typer.Option(help="csv with columns place, site: places that W2W calls otherwise.")
    ] = None,
    activities: Annotated[
        Path | None,
        typer.Option(help="csv with columns recorded, simulated: activities that RESULTS calls otherwise."),
    ] = None,
    data_set: Annotated[
        str, typer.Option("--as", help=f"RECORDINGS are those of {', '.join(DATA_SETS)}.")
    ] = "",
    seed: Seed = 0,
) -> None:
    """Your own recordings against the same sites of a simulated study. Unpaired.

    By the rules of the data sets that are compared here (docs/truth.md): regret at most .03, rho of mean F1
    at least .8 of its ceiling.

    Exit codes: 0 written, 2 wrong use (and why).
    """
    console = wide_console()
    with _published(console, out, labels, sites, activities) as folder:
        if data_set and data_set not in DATA_SETS:
            raise ValueError(f"--as must be {', '.join(DATA_SETS)}, not {data_set}")
        if data_set and (labels or sites or activities):
            raise ValueError("--as has names of its own: leave --labels, --sites and --activities out")
        study = StudyResults.load(results)
        with RunMonitor(console).step("reading, simulating and ranking"):
            if data_set:
                protocol = DATA_SETS[data_set]
                worn = protocol.read(recordings)
            else:
                worn = Recordings.read(recordings, labels)
                protocol = own_protocol(worn, study, Names.read(sites, activities))
            protocol, simulate = against_run(protocol, worn, study)
            found = compare_worn(protocol, worn, simulate, seed, console.print)
        console.print(write_protocol(folder, protocol, found))


@VALIDATE.command(name="utd-mhad")
def utd_mhad(
    path: Annotated[Path, typer.Argument(metavar="PATH", help="UTD-MHAD's folder, or an npz of it.")],
    out: Out,
    cutoff: Annotated[
        float, typer.Option(min=0.5, max=7, help="Band of the joints' paths, Hz.")
    ] = POSE_CUTOFF_HZ,
    sensor: Annotated[str, declared("sensor")] = DEFAULT_SENSOR,
    seed: Seed = 0,
) -> None:
    """UTD-MHAD: 27 actions, Kinect and one worn sensor. Trained on one side, tested on the other.

    Exit codes: 0 written, 2 wrong use (and why).
    """
    console = wide_console()
    with _published(console, out) as folder:
        part = chosen_sensor(sensor)
        with RunMonitor(console).step("reading UTD-MHAD"):
            trials = read_utd_mhad(path)
        with RunMonitor(console).step("fitting poses, simulating and training"):
            parts = compare_utd(trials, cutoff, part, seed)
        console.print(write_utd(folder, parts, part))


def _add(name: str, shows: str) -> None:
    """Add the command of a data set about which all is fixed."""
    protocol = DATA_SETS[name]

    def command(
        path: Annotated[Path, typer.Argument(metavar="REAL", help=protocol.file_help)],
        libraries: Libraries,
        out: Out,
        seed: Seed = 0,
    ) -> None:
        _compare(lambda _: protocol, path, libraries, out, seed)

    command.__doc__ = (
        f"{protocol.name}: {shows}, against clips of libraries. Unpaired.\n\n{FIXED}\n\n"
        "Exit codes: 0 written, 2 wrong use (and why)."
    )
    VALIDATE.command(name=name)(command)


FIXED = "Everything else was fixed before anything was computed (docs/evidence/people.md)."
for _name, _shows in {
    "dsads": "seven daily and sports activities, five sensors",
    "mhad": "11 actions, six accelerometers",
    "umafall": "12 daily activities, four sensors",
    "upfall": "six daily activities, five sensors",
}.items():
    _add(_name, _shows)


@VALIDATE.command(name="mighar")
def mig_har(
    path: Annotated[Path, typer.Argument(metavar="REAL", help="The data set's folder of subject1 to 12.")],
    libraries: Libraries,
    out: Out,
    sensors: Annotated[
        Path | None,
        typer.Option(
            help="csv with columns sensor, region, vertex: where you find the garment's sensors on its "
            "pictures.  [default: an empty one is written to OUT]",
            show_default=False,
        ),
    ] = None,
    seed: Seed = 0,
) -> None:
    """MIG HAR: a garment of 396 sensors, 14 activities, against clips of libraries. Unpaired.

    Everything else was fixed before anything was computed (docs/evidence/people.md). Sensors count from 0 in
    the order of the files' columns; those of one region, such as "left wrist", are one site.

    Exit codes: 0 written, 2 wrong use (and why).
    """
    if sensors is None:
        with refused(RunMonitor(wide_console())):
            out.mkdir(parents=True, exist_ok=True)
            empty = out / "sensors.csv"
            if not empty.exists():
                write_empty_positions(empty)
            raise ValueError(
                f"Where the sensors sit is published as pictures alone. {empty} lists them all: give those "
                "you want a region or a vertex there, and pass it with --sensors"
            )

    _compare(lambda told: mighar_set(sensors, told), path, libraries, out, seed, sensors)


@VALIDATE.command()
def gait(
    path: Annotated[
        Path, typer.Argument(metavar="PATH", help="Folder with the trial's csv files and xsens_<TRIAL>.bvh.")
    ],
    out: Out,
    trial: Annotated[str, typer.Option(help="Which trial.")] = "S02-Trial-Walk-1",
    sensor: Annotated[str, declared("sensor")] = "xsens mtw awinda",
    seed: Seed = 0,
) -> None:
    """A walk with nine worn Xsens sensors: signals, energies and gait phases, site by site.

    Exit codes: 0 written, 2 wrong use (and why).
    """
    console = wide_console()
    with _published(console, out) as folder:
        part = chosen_sensor(sensor)
        with RunMonitor(console).step("simulating and comparing"):
            found = compare_gait(path, trial, seed, part)
        console.print(write_gait(folder, found, part))


def _classifier(name: str) -> str:
    """The name of a classifier that there is."""
    if name not in CLASSIFIERS:
        raise ValueError(f"--classifier must be {', '.join(CLASSIFIERS)}, not {name}")
    if problem := unavailable(name):
        raise ValueError(problem)
    return name


def _compare_paired(
    protocol_of: Callable[[], Protocol],
    path: Path,
    out: Path,
    sensor: str,
    classifier: str,
    folds: int,
    seed: int,
) -> None:
    console = wide_console()
    with _published(console, out) as folder:
        part = chosen_sensor(sensor)
        protocol = replace(protocol_of(), sensor=part, classifier=_classifier(classifier), folds=folds)
        with RunMonitor(console).step(f"reading {protocol.name}"):
            trials = protocol.read(path)
        with RunMonitor(console).step("fitting poses, simulating and ranking"):
            found = run_protocol(protocol, partial(paired_sides, protocol, trials, seed), seed)
        _write(folder, found, protocol.title, console)


def _compare(
    protocol_of: Callable[[Callable[[str], None]], Protocol],
    path: Path,
    libraries: list[Path],
    out: Path,
    seed: int,
    *inputs: Path,
) -> None:
    """Compare a data set with libraries; its protocol is given how to say what it leaves out."""
    console = wide_console()
    with _published(console, out, *inputs) as folder:
        with RunMonitor(console).step("reading, simulating and ranking"):
            protocol = protocol_of(console.print)
            found = against_libraries(protocol, path, libraries, seed, console.print)
        console.print(write_protocol(folder, protocol, found))


@contextmanager
def _published(console: Console, out: Path, *inputs: Path) -> Iterator[Path]:
    """A folder to write, which becomes OUT; what is wrong with the data as a sentence, not as a traceback."""
    with ending(USAGE, console):
        with published(out, inputs) as folder:
            yield folder
        console.print(f"Written to {clean(out)}")


def _write(folder: Path, found: Sequence[Found], title: str, console: Console) -> None:
    for one in found:
        headline = f"{title}, {one.name}" if one.name else title
        write_validation(folder, one, headline)
        console.print(headline, style="bold")
        console.print(f"{one.validation.sentence()}\n")
        console.print("\n".join(agreement_table(one.validation)))
        console.print(f"\nReport: report{one.suffix}.md")
