# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished run for exports: its clips, its signals at chosen places, its motions at a rate."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import N_JOINTS, Body
from ..imu.recording import ImuRecording
from ..imu.sensor import SensorModel
from ..motion.motion import Motion, at_rate
from ..motion.skinning import patch_matrices
from ..patches.naming import place, resolve
from ..patches.own_placements import patches_at
from ..patches.patches import PatchSet
from ..study.config import StudyConfig
from ..study.results import StudyResults
from ..study.signals import simulate
from ..wording import plain_words

ALL = "all"

STILL_FRAMES = 50
"""Length of the T-pose that is recorded for its orientations."""


@dataclass(frozen=True)
class StudySignals:
    """A finished run, at some of its patches."""

    study: StudyResults
    patches: tuple[int, ...]

    @classmethod
    def at(cls, study: StudyResults, places: str, say: Callable[[str], object]) -> StudySignals:
        """The run at places given by their names, ``all`` of them, or by default those it chose.

        `say` is given the distance of a place's patch from it. Raises ValueError for a name that means no
        place, is near no patch (`naming.resolve`), or means the same as another.
        """
        if places.strip().lower() == ALL:
            return cls(study, tuple(range(len(study.patches))))
        if not places.strip():
            worn = study.summary["worn_together"]
            chosen = worn["places"] if worn else [study.summary["best_single_patch"]]
            return cls(study, tuple(patch["patch"] for patch in chosen))
        names = [name.strip() for name in places.split(",") if name.strip()]
        patches = [resolve(name, study.body(), study.patches, say, 0.0) for name in names]
        for later, patch in enumerate(patches):
            earlier = patches.index(patch)
            if earlier < later:
                both = f"'{names[earlier]}' and '{names[later]}'"
                raise ValueError(f"{both} are both the place {study.patches.names[patch]}: leave one out")
        return cls(study, tuple(patches))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the sensor sites."""
        return tuple(self.study.patches.names[patch] for patch in self.patches)

    @cached_property
    def config(self) -> StudyConfig:
        """The parameters of the run."""
        return self.study.config()

    def recordings(self) -> Iterator[ImuRecording]:
        """The run's recording of each clip, at the places, under the clip's labels."""
        for number, clip in enumerate(self.study.clips):
            recording = self.study.recording(number, list(self.patches))
            yield recording.labelled(self.names, clip.activity, clip.subject, clip.name)


def placed(study: StudyResults, names: list[str]) -> PatchSet:
    """Sensors at vertices: of the run's patches, of vertex numbers, and right at named places.

    Raises ValueError for an unknown name, or two that mean one vertex.
    """
    body = study.body()
    patch_at = dict(zip(map(str.lower, study.patches.names), study.patches.vertices.tolist(), strict=True))
    where = {}
    for name in names:
        plain = plain_words(name)
        if plain.isdigit():
            where[f"vertex {int(plain)}"] = int(plain)
        else:
            where[name] = patch_at[plain] if plain in patch_at else place(name, body)
    return patches_at(body, where)


@dataclass(frozen=True, eq=False)
class WornClip:
    """Recording of N sensors in one clip of T samples, with the true motion."""

    recording: ImuRecording
    motion: Motion  # at the recording's rate, T frames
    # (T, N, 3, 3), sensor to world, z up: recorded if the run records them, else true
    orientations: np.ndarray
    rest: np.ndarray  # (N, 3, 3): the same in the T-pose, as a calibration finds them


@dataclass(frozen=True)
class WornSignals:
    """Signals of a finished run, recorded anew at another rate by one sensor model at chosen sites."""

    study: StudyResults
    patches: PatchSet
    rate: float
    sensor: SensorModel

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the sensor sites."""
        return self.patches.names

    @cached_property
    def body(self) -> Body:
        """The body that wears them."""
        return self.study.body()

    def clips(self) -> Iterator[WornClip]:
        """Each clip of the run, with the true pose and the orientations at its samples.

        Raises ValueError if the run's signals are not physical or are on cloth.
        """
        config = self.study.config()
        if config.synthesis.convention != "physical":
            raise ValueError(
                "the run was made with --convention paper, whose signals are in no one frame: they cannot be "
                "turned back; run it with the physical convention"
            )
        if not config.on_skin:
            raise ValueError(
                "sensors of the run sit on cloth, whose signals are made by the run alone: they stand in its "
                "folder signals, at the rate of the run"
            )
        synthesis = replace(config.synthesis, rate_hz=self.rate)
        config = replace(config, synthesis=synthesis, sensor=self.sensor.name, own_sensor=self.sensor)
        turns = np.tile(np.eye(3), (STILL_FRAMES, N_JOINTS, 1, 1))
        t_pose = Motion(turns, np.tile(self.body.joints[0], (STILL_FRAMES, 1)), self.rate)
        for clip in self.study.clips:
            labels = clip.activity, clip.subject, clip.name
            motion, still = self.study.motion(clip.name).labelled(*labels), t_pose.labelled(*labels)
            recording = simulate(self.body, self.patches, motion, config)
            sampled = at_rate(motion, self.rate)
            if recording.orientation is None:
                moved, rested = self._orientations(sampled), self._orientations(still)
            else:  # the errors are the clip's: a calibration in it has them, too
                moved = _as_read(recording.orientation)
                at_rest = simulate(self.body, self.patches, still, config).orientation
                assert at_rest is not None
                rested = _as_read(at_rest)
            yield WornClip(recording, sampled, moved, rested[0])

    def _orientations(self, motion: Motion) -> np.ndarray:
        return patch_matrices(self.body, self.patches.triangles, motion)[..., :3, :3]


def _as_read(quaternions: np.ndarray) -> np.ndarray:
    """Orientations (T, N, 3, 3) of quaternions w, x, y, z; where samples are lost, the last that arrived."""
    arrived = np.isfinite(quaternions).all(axis=2)
    last = np.maximum.accumulate(np.where(arrived, np.arange(len(quaternions))[:, None], 0), axis=0)
    held = np.take_along_axis(quaternions, last[..., None], axis=0)
    turns = Rotation.from_quat(held.reshape(-1, 4), scalar_first=True)
    return turns.as_matrix().reshape(*held.shape[:2], 3, 3)
