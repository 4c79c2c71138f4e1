# SPDX-License-Identifier: GPL-3.0-or-later
"""DSADS's five worn sensors against the same activities simulated from a user's motion library: unpaired."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.library.library import read_library
from w2w.core.motion.source import UnusableMotion
from w2w.core.ranking.utility import inputs_of
from w2w.core.windows.windows import WindowSpec
from w2w.headless.runs.clip import load_clip

from ..datasets.dsads import DSADS_RATE, DSADS_SITES, read_dsads
from ..validation.dsads import DSADS
from ..validation.protocol import Found
from ..validation.site_windows import site_windows
from ..validation.sites import validate_sites
from .posture import posture
from .site_simulator import SiteSimulator, error_sentence
from .unpaired import Moving, distinct, noise_name

MATCHES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "walking": (("walking in parking lot", "walking on flat treadmill"), ("walking", "walk")),
    "running": (("running on treadmill",), ("running", "run", "jogging", "jog", "dash")),
    "standing": (("standing",), ()),
    "sitting": (("sitting",), ()),
    "ascending stairs": (("ascending stairs",), ("climbing_stairs", "ascending_stairs", "stair_climbing")),
    "jumping": (("jumping",), ("jumping", "jumping_jacks", "jump", "hop")),
    "playing basketball": (("playing basketball",), ("dribbling", "playing_basketball")),
    "rowing": (("rowing",), ("rowing",)),
    "cycling": (("cycling horizontal", "cycling vertical"), ("cycling", "riding_bike")),
    "lying": (("lying on back", "lying on right side"), ("lying", "laying", "sleeping")),
}
"""Name -> DSADS's activities, and labels of a motion library, that show the same."""

STILL = (
    "standing", "standing_idle", "idle", "sitting", "sitting_idle", "typing", "eating", "drinking", "talking",
    "pointing", "using_phone", "greeting", "nodding", "shaking_head", "clapping", "beckoning",
)  # fmt: skip
"""Labels of clips that show people who stay where they are: their thighs say whether they sit or stand."""


SITES = DSADS.sites


def simulated_recordings(
    folders: Sequence[Path], labels: Sequence[Path | None], simulator: SiteSimulator
) -> tuple[list[ImuRecording], list[str]]:
    """Recordings of a library's matching clips at DSADS's sites, and the clips that cannot be read.

    Clips that show one motion bear one name.
    """
    wanted = {label: name for name, (_, theirs) in MATCHES.items() for label in theirs}
    found, recordings, unusable = [], [], []
    for number, (folder, table) in enumerate(zip(folders, labels, strict=True)):
        for clip in read_library(folder, table).clips:
            if clip.activity not in wanted and clip.activity not in STILL:
                continue
            try:
                _, motion, _ = load_clip(clip, simulator.body)
                activity = wanted.get(clip.activity) or posture(simulator.body, motion)
                if not activity:
                    continue
                recordings.append(
                    simulator.record(motion.labelled(activity, clip.subject, noise_name(clip.name)))
                )
            except (UnusableMotion, ValueError) as error:
                unusable.append(f"{clip.file}: {error}")
                continue
            named = motion.labelled(activity, clip.subject, f"{number} {clip.name}")
            found.append(Moving(named, "", clip.name, clip.motion_key))
    if not recordings:
        known = ", ".join(sorted(wanted))
        raise ValueError(f"no clip of the library shows what DSADS has: label them as any of {known}")
    named = distinct(found)
    return [replace(r, clip=one.motion.clip) for r, one in zip(recordings, named, strict=True)], unusable


def real_recordings(path: Path) -> list[ImuRecording]:
    """DSADS's segments of the activities that can be matched, one clip a person and activity."""
    names = {theirs: name for name, (of_dsads, _) in MATCHES.items() for theirs in of_dsads}
    return [
        replace(r, activity=names[r.activity], clip=f"{r.activity} {r.subject}", sites=tuple(SITES))
        for r in read_dsads(path)
        if r.activity in names
    ]


def compare_dsads(
    path: Path,
    folders: Sequence[Path],
    labels: Sequence[Path | None],
    window_s: float = 5.0,
    sensor: SensorModel = DSADS.sensor,
    classifier: str = "ridge",
    seed: int = 0,
) -> Found:
    """Compare worn sensors with those of a library whose labels, not names, say what its clips show."""
    worn = real_recordings(path)
    simulator = SiteSimulator(SITES, DSADS_RATE, sensor, seed)
    simulated, unusable = simulated_recordings(folders, labels, simulator)
    shared = [name for name in MATCHES if any(r.activity == name for r in simulated)]
    real = [r for r in worn if r.activity in shared]
    spec = WindowSpec(length_s=window_s, stride_s=min(1.0, window_s), short="reflect")
    inputs = inputs_of(classifier)
    found = validate_sites(
        *(site_windows(side, spec, inputs=inputs) for side in (real, simulated)), DSADS_SITES, shared,
        by_subject=(True, False), seed=seed, classifier=classifier,
    )  # fmt: skip
    clips = {name: len({r.clip for r in simulated if r.activity == name}) for name in shared}
    seconds = float(np.median([r.n_samples / r.rate for r in simulated]))
    notes = [
        "Unpaired: other people, other surroundings, other instructions than in the simulated clips.",
        "Distinct simulated motions: " + ", ".join(f"{name} {count}" for name, count in clips.items()) + ".",
        f"Half the simulated clips are shorter than {seconds:.1f} s; short ones are played forwards and "
        f"backwards to fill windows of {window_s:g} s, at {DSADS_RATE:g} Hz.",
        error_sentence(sensor),
        "Whether a clip without a step shows sitting or standing was read from its thighs.",
        f"{len(unusable)} clips could not be used." if unusable else "All matching clips were used.",
    ]
    return Found("", "", found, notes, simulator.simulated_at)
