# SPDX-License-Identifier: GPL-3.0-or-later
"""What an export is made of: a finished run's clips, its signals at chosen places, its motions at a rate."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import Body
from ..body.skeleton import N_JOINTS
from ..clip_files import signals_file
from ..imu.recording import READINGS, ImuRecording, Reading
from ..imu.sensor import SensorModel
from ..motion.motion import Motion, at_rate
from ..motion.skinning import patch_matrices
from ..patches.naming import place, resolve
from ..patches.own_placements import patches_at
from ..patches.patches import PatchSet
from ..results_folder import StudyResults
from ..study import StudyConfig, record
from ..wording import plain_words

ALL = "all"

STILL_FRAMES = 50
"""Of a T-pose that is recorded for its orientations."""


@dataclass(frozen=True)
class StudySignals:
    """A finished run, seen at some of its places.

    Parameters
    ----------
    study : StudyResults
    patches : tuple of int
        Of the run.
    """

    study: StudyResults
    patches: tuple[int, ...]

    @classmethod
    def at(
        cls, study: StudyResults, places: str, say: Callable[[str], object] = warnings.warn
    ) -> StudySignals:
        """The run at places given by their names, ``all`` of them, or by default those it chose.

        `say` is told how far the patch that stands for a place is from it.

        Raises
        ------
        ValueError
            If a name means no place, or no patch is near it (`naming.resolve`), or two mean the same.
        """
        if places.strip().lower() == ALL:
            return cls(study, tuple(range(len(study.patches))))
        if not places.strip():
            return cls(study, _chosen(study))
        found = [resolve(name, study.body(), study.patches, say, 0.0) for name in _names(places)]
        _refuse_same(_names(places), [study.patches.names[patch] for patch in found])
        return cls(study, tuple(found))

    @property
    def names(self) -> tuple[str, ...]:
        """Of the places."""
        return tuple(self.study.patches.names[patch] for patch in self.patches)

    @property
    def readings(self) -> tuple[Reading, ...]:
        """What the run recorded at each place."""
        names = ("acc", "gyr", *self.config.further.record)
        return tuple(reading for reading in READINGS if reading.name in names)

    @cached_property
    def config(self) -> StudyConfig:
        """The parameters of the run."""
        return self.study.config()

    def recordings(self) -> Iterator[ImuRecording]:
        """What the run recorded of each clip, at the places, under the clip's labels.

        Raises
        ------
        ValueError, OSError
            If a recording is missing or damaged.
        """
        chosen = list(self.patches)
        for clip in self.study.clips:
            found = ImuRecording.load(signals_file(self.study.out, clip.name)).at(chosen)
            labels = {"activity": clip.activity, "subject": clip.subject, "clip": clip.name}
            yield replace(found, sites=self.names, **labels)


def placed(study: StudyResults, names: list[str]) -> PatchSet:
    """Sensors at vertices: of the run's patches, of vertex numbers, and right at named places.

    Raises
    ------
    ValueError
        If a name means nothing, or two mean one vertex.
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
class Worn:
    """Sensors through one clip, with what no sensor knows.

    Parameters
    ----------
    recording : ImuRecording
        T samples of N sensors.
    motion : Motion
        The clip at the recording's rate, T frames.
    orientations : ndarray, shape (T, N, 3, 3)
        Sensor to world, z up: as recorded where the run records orientation, else the true ones.
    rest : ndarray, shape (N, 3, 3)
        The same in the T-pose, as a calibration finds them.
    """

    recording: ImuRecording
    motion: Motion
    orientations: np.ndarray
    rest: np.ndarray


def worn(study: StudyResults, patches: PatchSet, rate: float, sensor: SensorModel) -> Iterator[Worn]:
    """Each clip of a run recorded anew at a rate, with the true pose and the orientations at its samples.

    Raises
    ------
    ValueError
        If the run's signals are not physical, or a motion is missing or damaged.
    """
    config = study.config()
    if config.synthesis.convention != "physical":
        raise ValueError(
            "the run was made with --convention paper, whose signals are in no one frame: they cannot be "
            "turned back; run it with the physical convention"
        )
    if config.garments:
        raise ValueError(
            f"the run wore {', '.join(config.garments)}, and signals on a garment are made by the run alone: "
            "they stand in its folder signals, at the rate of the run"
        )
    body = study.body()
    synthesis = replace(config.synthesis, rate_hz=rate)
    config = replace(config, synthesis=synthesis, sensor=sensor.name, own_sensor=sensor)
    for clip in study.clips:
        motion = study.motion(clip.name).labelled(clip.activity, clip.subject, clip.name)
        recording = record(body, patches, motion, config)
        sampled = at_rate(motion, rate)
        still = _t_pose(body, rate).labelled(clip.activity, clip.subject, clip.name)
        if recording.orientation is None:
            moved, rested = (patch_matrices(body, patches.triangles, pose) for pose in (sampled, still))
            yield Worn(recording, sampled, moved[..., :3, :3], rested[0, :, :3, :3])
        else:  # the errors are the clip's: a calibration in it has them, too
            rested = _as_read(record(body, patches, still, config).orientation)
            yield Worn(recording, sampled, _as_read(recording.orientation), rested[0])


def _t_pose(body: Body, rate: float) -> Motion:
    return Motion(
        np.tile(np.eye(3), (STILL_FRAMES, N_JOINTS, 1, 1)), np.tile(body.joints[0], (STILL_FRAMES, 1)), rate
    )


def _as_read(quaternions: np.ndarray) -> np.ndarray:
    """Orientations (T, N, 3, 3) of quaternions w, x, y, z; where samples are lost, the last that arrived."""
    arrived = np.isfinite(quaternions).all(axis=2)
    last = np.maximum.accumulate(np.where(arrived, np.arange(len(quaternions))[:, None], 0), axis=0)
    held = np.take_along_axis(quaternions, last[..., None], axis=0)[..., [1, 2, 3, 0]]
    return Rotation.from_quat(held.reshape(-1, 4)).as_matrix().reshape(*held.shape[:2], 3, 3)


def _chosen(study: StudyResults) -> tuple[int, ...]:
    """The patches that the run chose to be worn together, else its single best."""
    summary = study.summary
    places = (summary.get("worn_together") or {}).get("places") or [summary["best_single_patch"]]
    return tuple(int(place["patch"]) for place in places)


def _names(places: str) -> list[str]:
    return [name.strip() for name in places.split(",") if name.strip()]


def _refuse_same(given: list[str], found: list[str]) -> None:
    for later, name in enumerate(found):
        earlier = found.index(name)
        if earlier < later:
            raise ValueError(
                f"'{given[earlier]}' and '{given[later]}' are both the place {name}: leave one out"
            )
