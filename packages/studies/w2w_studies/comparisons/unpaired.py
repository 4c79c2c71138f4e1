# SPDX-License-Identifier: GPL-3.0-or-later
"""Worn sensors of a data set against the same activities simulated from motion libraries, by a protocol."""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.body.body import Body
from w2w.core.body.landmarks import SensorSite
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.synthesis import Synthesis
from w2w.core.imu.virtual import at_patches, record_motion
from w2w.core.keypoints.fit import fit_keypoints
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.library.library import LibraryError, read_library
from w2w.core.motion.motion import Motion
from w2w.core.motion.signature import motion_signature
from w2w.core.motion.source import UnusableMotion
from w2w.core.patches.body_parts import patches_named
from w2w.core.patches.naming import resolve
from w2w.core.patches.patches import PatchSet, sample_patches
from w2w.core.reading.look import look_up
from w2w.core.reading.reader import Reader
from w2w.core.study.ranking import same_motion_groups
from w2w.headless.runs.clip import load_clip
from w2w.headless.runs.clip_task import Engine

from ..datasets.utd_mhad import read_utd_mhad
from ..validation.protocol import BY_POSTURE, KINECT, Analysis, Match, Protocol
from ..validation.site_scores import SiteScores, site_scores
from ..validation.site_windows import SiteWindows, site_windows
from .posture import posture

KINECT_20 = JOINT_SETS["kinect-20"]

KINECT_FILES = (
    f"{KINECT} is read from the folder of Inertial and Skeleton, with their .mat files, or from an npz"
)


class Moving(NamedTuple):
    """A motion under its labels, and the source it is from."""

    motion: Motion  # its clip is the first that shows this motion, with its library's number
    source: str
    own_name: str  # of the clip itself, by which its sensors' errors are drawn (`noise_name`)


def noise_name(clip: str) -> str:
    """What the errors of a clip's sensors are drawn by, whatever other libraries there are.

    Clips of one name share them. The number once told libraries apart; with that of an only library, its
    signals are what they were.
    """
    return f"0 {clip}"


class Side(NamedTuple):
    """Recordings of the sensors of a protocol's sites, their windows, and where each clip is from."""

    recordings: list[ImuRecording]
    windows: SiteWindows
    source_of: dict[str, str]


class Simulated(NamedTuple):
    """The simulated side of an analysis, and what a reader must know of it."""

    side: Side
    at: tuple[str, ...]  # what stood for each site
    site_of: np.ndarray  # site of each sensor
    notes: list[str]


class RegionSimulator:
    """Records motions with a sensor on every patch of each site.

    `every` records each so-many-th of the other patches too, after those of the sites; 0 records none.
    """

    def __init__(self, body: Body, protocol: Protocol, seed: int = 0, every: int = 0) -> None:
        patches = sample_patches(body)
        self.body, self.protocol, self.seed = body, protocol, seed
        chosen, self.site_of, self.simulated_at = patches_at_sites(protocol.sites.values(), patches, body)
        others = np.setdiff1d(np.arange(len(patches)), chosen)[::every] if every else []
        self.patches = [*chosen, *others]
        self._patches = at_patches(patches, self.patches)

    def record(self, moving: Moving, cutoff_hz: float) -> ImuRecording:
        """What the sensors would record; the paths of a Kinect's joints are limited already."""
        settings = Synthesis(rate_hz=self.protocol.rate_hz)
        if moving.source != KINECT:
            settings = replace(settings, cutoff_hz=cutoff_hz)
        motion = replace(moving.motion, clip=noise_name(moving.own_name))
        made = record_motion(self.body, self._patches, motion, settings, self.protocol.sensor, self.seed)
        return replace(made, clip=moving.motion.clip)

    def side(self, motions: Sequence[Moving], analysis: Analysis) -> Side:
        """Windows of the clips that take part in an analysis."""
        chosen = [
            moving
            for moving in motions
            if moving.source in analysis.sources and moving.motion.activity in analysis.activities
        ]
        if not chosen:
            raise ValueError(f"no clip of the libraries takes part in '{analysis.name}'")
        recordings, unusable = [], {}
        for moving in chosen:
            try:
                made = self.record(moving, analysis.cutoff_hz)
                recordings.append(replace(made, activity=analysis.label(made.activity)))
            except ValueError as error:
                unusable[moving.motion.clip] = f"clip '{moving.motion.clip}': {error}"
        if not recordings:
            raise ValueError(next(iter(unusable.values())))
        windows = site_windows(recordings, self.protocol.windows, self.protocol.use)
        windows.skipped.update(unusable)
        return Side(recordings, windows, {moving.motion.clip: moving.source for moving in chosen})


def patches_at_site(site: str | SensorSite | int, patches: PatchSet, body: Body) -> list[int]:
    """Patches that stand for a site: those of the regions of its name, else the nearest one.

    Raises ValueError if nothing has its name, or the body no such vertex; the message says which.
    """
    if isinstance(site, str):
        try:
            return patches_named(patches.regions, site).tolist()
        except ValueError:
            return [resolve(site, body, patches)]
    vertex = site if isinstance(site, int) else site.vertex(body)
    if vertex >= len(patches.labels):
        raise ValueError(f"the body has {len(patches.labels)} vertices, from 0: none has the number {vertex}")
    return [int(patches.labels[vertex])]


def patches_at_sites(
    sites: Iterable[str | SensorSite | int], patches: PatchSet, body: Body
) -> tuple[list[int], np.ndarray, tuple[str, ...]]:
    """The patches that stand for sites, the site of each, and what stands for each site in words."""
    of_sites = [patches_at_site(site, patches, body) for site in sites]
    site_of = np.repeat(np.arange(len(of_sites)), [len(some) for some in of_sites])
    at = (f"{len(some)} patches" if len(some) > 1 else patches.names[some[0]] for some in of_sites)
    return list(chain(*of_sites)), site_of, tuple(at)


def load_motions(
    protocol: Protocol, libraries: Sequence[Path], body: Body, told: Callable[[str], None] = lambda _: None
) -> tuple[list[Moving], list[str]]:
    """The libraries' clips that the protocol's rules name, each distinct motion under one name.

    `libraries`: folders of motion files, or UTD-MHAD's archive or folder.
    `told`: given a sentence for each library of which nothing is used.
    Also returns the clips that could not be read, each with the reason.
    Raises ValueError if no clip fits a rule.
    """
    found: list[Moving] = []
    unusable: list[str] = []
    for number, library in enumerate(libraries):
        used = False
        for name, loaded in chain(*(read(protocol, library, body) for read in _readers(library))):
            used = True
            if isinstance(loaded, str):
                unusable.append(f"{name}: {loaded}")
                continue
            motion, match = loaded
            activity = posture(body, motion) if match.activity == BY_POSTURE else match.activity
            if not activity:
                continue
            labelled = motion.labelled(activity, match.who, f"{number} {name}")
            found.append(Moving(labelled, match.source, name))
        if not used:
            told(f"Nothing of {library} is used: {_unknown(protocol)}.")
    if not found:
        raise ValueError(f"no clip of the libraries can be used: {_unknown(protocol)}")
    return distinct(found), unusable


def _unknown(protocol: Protocol) -> str:
    """Why nothing of a library is used."""
    sources = dict.fromkeys(rule.source for rule in protocol.rules)
    kinect = f" ({KINECT_FILES})" if KINECT in sources else ""
    return f"no file has a name that {', '.join(sources)} give to what {protocol.name} shows{kinect}"


Loaded = Iterator[tuple[str, tuple[Motion, Match] | str]]


def _readers(library: Path) -> list[Callable[[Protocol, Path, Body], Loaded]]:
    """How to read what a library holds: UTD-MHAD's skeletons, files of motion, or both."""
    if library.is_file():
        return [_kinect]
    if not any(library.rglob("a*_s*_t*_skeleton.mat")):
        return [_files]
    try:
        read_library(library, own_labels=False)
    except LibraryError:
        return [_kinect]
    return [_kinect, _files]


def _files(protocol: Protocol, library: Path, body: Body) -> Loaded:
    try:
        clips = read_library(library, own_labels=False).clips
    except LibraryError as error:
        raise ValueError(f"{error} ({KINECT_FILES})") from error
    with Reader() as reader:
        ups = look_up(reader, ((clip.file, clip.path) for clip in clips)).ups
    for clip in clips:
        match = protocol.match(clip.file)
        if match is None or match.source == KINECT:
            continue
        try:
            yield clip.name, (load_clip(clip, body, Engine(ups=ups))[1], match)
        except (UnusableMotion, ValueError) as error:
            yield clip.file, str(error)


def _kinect(protocol: Protocol, library: Path, body: Body) -> Loaded:
    for trial in read_utd_mhad(library):
        name = trial.recording.clip
        match = protocol.match(name)
        if match is None or match.source != KINECT:
            continue
        try:
            fit = fit_keypoints(trial.skeleton, trial.skeleton_rate, KINECT_20, body, "y", protocol.kinect_hz)
            yield name, (fit.motion, match)
        except ValueError as error:
            yield name, str(error)


def distinct(found: Sequence[Moving]) -> list[Moving]:
    """Clips that show one motion, under the name and the mover of the first of them."""
    signatures = [motion_signature(moving.motion) for moving in found]
    groups = same_motion_groups([moving.motion.clip for moving in found], signatures=signatures)
    firsts = [found[int(np.flatnonzero(groups == group)[0])].motion for group in groups]
    return [
        moving._replace(motion=moving.motion.labelled(moving.motion.activity, first.subject, first.clip))
        for moving, first in zip(found, firsts, strict=True)
    ]


def real_side(protocol: Protocol, recordings: Sequence[ImuRecording], analysis: Analysis) -> Side:
    """The worn sensors in an analysis, each under its site's name, or its own if sites have several."""
    sites = tuple(protocol.sites) if protocol.worn_site_of is None else recordings[0].sites
    kept = [number for number, site in enumerate(sites) if site in (analysis.sites or sites)]
    chosen = [
        replace(r, activity=analysis.label(activity), sites=sites).at(kept)
        for r in recordings
        if (activity := protocol.activity_of(r.activity)) in analysis.activities
    ]
    if not chosen:
        raise ValueError(f"no recording of {protocol.name} takes part in '{analysis.name}'")
    return Side(chosen, site_windows(chosen, protocol.windows, protocol.use), {})


def scores_of(
    windows: SiteWindows, activities: Sequence[str], site_of: np.ndarray | None, seed: int
) -> SiteScores:
    """F1 by site of those activities that can be tested, one person left out at a time."""
    found = windows.ranked(activities, by_subject=True, seed=seed)
    return site_scores(found, windows.person_of(), site_of, seed)


def library_simulation(
    protocol: Protocol, libraries: Sequence[Path], seed: int, told: Callable[[str], None]
) -> Callable[[Analysis], Simulated]:
    """Reads the libraries; gives what simulates an analysis."""
    body = Body.bundled()
    motions, unusable = load_motions(protocol, libraries, body, told)

    def simulate(analysis: Analysis) -> Simulated:
        sites = {site: protocol.sites[site] for site in analysis.sites or protocol.sites}
        simulator = RegionSimulator(body, replace(protocol, sites=sites), seed)
        made = simulator.side(motions, analysis)
        shown = [moving for moving in motions if moving.motion.clip in made.source_of]
        notes = [f"Distinct simulated motions: {_clips_in_words(shown)}."]
        if unusable:
            notes.append(f"Library {skipped_note(unusable)}")
        return Simulated(made, simulator.simulated_at, simulator.site_of, notes)

    return simulate


def skipped_note(reasons: Collection[str]) -> str:
    """How many clips could not be used, and why the first could not."""
    return f"clips that could not be used: {len(reasons)}; the first: {next(iter(reasons))}."


def _clips_in_words(motions: Sequence[Moving]) -> str:
    """How many clips of each activity are from where."""
    counts: dict[str, dict[str, set[str]]] = {}
    for moving in motions:
        of = counts.setdefault(moving.motion.activity, {})
        of.setdefault(moving.source, set()).add(moving.motion.clip)
    return "; ".join(
        f"{activity} " + ", ".join(f"{source} {len(clips)}" for source, clips in by_source.items())
        for activity, by_source in counts.items()
    )
