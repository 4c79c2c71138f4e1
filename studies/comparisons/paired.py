# SPDX-License-Identifier: GPL-3.0-or-later
"""Data sets that have both video pose and worn sensors: the body follows the pose, clip by clip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from w2w.core.body.body import Body
from w2w.core.imu.presets import DEFAULT_SENSOR, PRESETS
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import Synthesis
from w2w.core.imu.wearing import error_sentence
from w2w.core.keypoints.fit import fit_keypoints, guess_up
from w2w.core.keypoints.joint_sets import JOINT_SETS, JointSet
from w2w.core.ranking.utility import inputs_of
from w2w.core.ranking.windows import WindowSpec

from ..datasets.mmfit import CAMERA_RATE, DEVICES, NON_ACTIVITY, RATE_HZ, Exercise
from ..datasets.vidimu import IMU_RATE, LOWER, SITES, UPPER, VIDEO_RATE, Trial
from ..validation.site_windows import Use, site_windows
from ..validation.sites import SiteValidation, validate_sites
from .site_simulator import SiteSimulator

BODY_34 = JOINT_SETS["body-34"]
MM_FIT_17 = JOINT_SETS["mm-fit-17"]

MMFIT_WINDOW = WindowSpec(length_s=5.0, stride_s=1.0)
"""The length of the authors' own windows."""

VIDIMU_WINDOW = WindowSpec(length_s=2.0, stride_s=0.5)

POSE_CUTOFF_HZ = 3.0
"""Band of video pose, chosen on UTD-MHAD (docs/validation.md)."""


@dataclass(frozen=True)
class Terms:
    """How sensors are simulated and both sides ranked.

    Parameters
    ----------
    sensor : SensorModel
        Of the simulated sensors.
    classifier : str
        Name in `utility.CLASSIFIERS`, for both sides.
    folds : int
        By clip, the same on both sides.
    seed : int
    """

    sensor: SensorModel = PRESETS[DEFAULT_SENSOR]
    classifier: str = "ridge"
    folds: int = 5
    seed: int = 0

    def simulator(self, sites: Mapping[str, str], rate: float) -> SiteSimulator:
        """Records motions of W2W's own body at some sites."""
        return SiteSimulator(Body.bundled(), sites, Synthesis(rate_hz=rate), self.sensor, self.seed)


AS_DEFAULT = Terms()


class Outcome(NamedTuple):
    """A comparison and what a reader must know.

    Attributes
    ----------
    name : str
        Which part of the data set; empty for all of it.
    found : SiteValidation
    notes : list of str
    simulated_at : tuple of str
        Patch of each site.
    """

    name: str
    found: SiteValidation
    notes: list[str]
    simulated_at: tuple[str, ...]


def compare_mmfit(
    exercises: Sequence[Exercise], terms: Terms = AS_DEFAULT, background: Sequence[str] = ()
) -> Outcome:
    """Validate on MM-Fit's exercises.

    Parameters
    ----------
    exercises : sequence of Exercise
    terms : Terms
    background : sequence of str
        Activities that the others are told apart from and that are not compared themselves.
    """
    sites = {site: site for site in DEVICES.values() if site in exercises[0].recording.sites}
    simulator = terms.simulator(sites, RATE_HZ)
    pairs, notes = _pairs(simulator, [(e.recording, e.pose) for e in exercises], MM_FIT_17, CAMERA_RATE)
    notes.append(error_sentence(terms.sensor))
    if any(real.activity == NON_ACTIVITY for real, _ in pairs):
        as_what = "background: trained against, compared with nothing" if background else "one of the classes"
        notes.append(f"What is done between the sets is {NON_ACTIVITY}, {as_what}.")
    notes.append(
        "Units of the real signals, the poses' upward axis and their sides were inferred from the files."
    )
    found = _validated(pairs, tuple(sites), MMFIT_WINDOW, terms, "both", background)
    return Outcome("", found, notes, simulator.simulated_at)


def compare_vidimu(trials: Sequence[Trial], terms: Terms = AS_DEFAULT) -> list[Outcome]:
    """Validate on VIDIMU: activities of the legs, then of the arms, for their sensors sat elsewhere."""
    outcomes = []
    for name, sites in (("lower body", LOWER), ("upper body", UPPER)):
        chosen = [(trial.recording, trial.pose) for trial in trials if trial.recording.sites == sites]
        if len({recording.activity for recording, _ in chosen}) < 2:
            continue
        simulator = terms.simulator({site: SITES[site] for site in sites}, IMU_RATE)
        pairs, notes = _pairs(simulator, chosen, BODY_34, VIDEO_RATE)
        notes.insert(
            0, "Angular velocity only: the sensors' files hold no accelerations, on neither side used."
        )
        notes.append(error_sentence(terms.sensor))
        found = _validated(pairs, sites, VIDIMU_WINDOW, terms, "gyr")
        outcomes.append(Outcome(name, found, notes, simulator.simulated_at))
    if not outcomes:
        raise ValueError("neither the lower nor the upper body has trials of two activities")
    return outcomes


def _pairs(
    simulator: SiteSimulator,
    clips: Sequence[tuple[ImuRecording, np.ndarray]],
    joint_set: JointSet,
    rate: float,
) -> tuple[list[tuple[ImuRecording, ImuRecording]], list[str]]:
    """Real and simulated recordings of the same clips, cut to the same length."""
    up = guess_up(np.concatenate([pose for _, pose in clips]), joint_set)
    pairs, unusable, exchanged = [], [], 0
    for real, pose in clips:
        try:
            fit = fit_keypoints(pose, rate, joint_set, simulator.body, up, POSE_CUTOFF_HZ)
            made = simulator.record(fit.motion.labelled(real.activity, real.subject, real.clip))
        except ValueError as error:
            unusable.append(f"{real.clip}: {error}")
            continue
        exchanged += fit.paths.exchanged
        n = min(real.n_samples, made.n_samples)
        pairs.append(
            (
                replace(real, acc=real.acc[:n], gyr=real.gyr[:n]),
                replace(made, acc=made.acc[:n], gyr=made.gyr[:n]),
            )
        )
    if not pairs:
        raise ValueError(f"no clip's pose can be fitted: {unusable[0]}")
    notes = [
        f"Paired: {len(pairs)} clips seen and worn at once. Nothing is fitted between pose and sensors.",
        f"The poses' {up} axis was taken to point up; in {exchanged} clips left and right were exchanged.",
    ]
    if unusable:
        notes.append(f"{len(unusable)} clips could not be fitted, the first: {unusable[0]}.")
    return pairs, notes


def _validated(
    pairs: Sequence[tuple[ImuRecording, ImuRecording]],
    sites: tuple[str, ...],
    spec: WindowSpec,
    terms: Terms,
    use: Use,
    background: Sequence[str] = (),
) -> SiteValidation:
    inputs = inputs_of(terms.classifier)
    sides = [site_windows(recordings, spec, use, inputs) for recordings in zip(*pairs, strict=True)]
    shared = set(sides[0].clip.tolist()) & set(sides[1].clip.tolist())  # gaps may have cost a side a clip
    kept = [side.some(np.isin(side.clip, list(shared))) for side in sides]
    activities = sorted(set(kept[0].activity.tolist()))
    return validate_sites(
        *kept, sites, activities, terms.folds, seed=terms.seed, classifier=terms.classifier,
        background=background,
    )  # fmt: skip
