# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished results folder, read back so that its ranking can be used again without baking anything."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from w2w.core.body.body import Body
from w2w.core.imu.augmentation import Augmentation
from w2w.core.imu.synthesis import Synthesis
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.inputs import PlaceBlocks
from w2w.core.ranking.utility import UtilityMap
from w2w.core.ranking.windows import WindowSpec
from w2w.core.selection.constraints import Constraints
from w2w.core.selection.subsets import multi_sensor_check
from w2w.core.study import StudyConfig, plain

from .clip_files import WORK, ClipWindows, ranking_inputs
from .study import Study

UTILITY = "utility.npz"
"""The whole ranking, with its intervals, confusions and predictions."""


@dataclass(frozen=True)
class FinishedClip:
    """A clip that took part.

    Parameters
    ----------
    name : str
        Its files' name.
    activity, subject : str
    motion : str
        Name of the first clip that shows the same motion: its own where there is no other.
    """

    name: str
    activity: str
    subject: str
    motion: str


@dataclass(frozen=True, eq=False)
class FinishedStudy:
    """What a run left in its folder.

    Parameters
    ----------
    out : Path
    utility : UtilityMap
    patches : PatchSet
    clips : tuple of FinishedClip
        The clips used, in the order of their windows.
    parameters : dict
        The run's `StudyConfig` as plain values.
    """

    out: Path
    utility: UtilityMap
    patches: PatchSet
    clips: tuple[FinishedClip, ...]
    parameters: dict[str, Any]

    @classmethod
    def load(cls, out: Path) -> FinishedStudy:
        """Read a results folder.

        Raises
        ------
        ValueError
            If it is none, or the run in it has not come to its end.
        """
        try:
            summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
            config = json.loads((out / "config.json").read_text(encoding="utf-8"))
            utility = UtilityMap.load(out / UTILITY)
            patches = PatchSet.load(out / WORK / "patches.npz")
            clips = _clips(summary["used"])
        except FileNotFoundError as error:
            raise ValueError(
                f"{out} is not the results folder of a finished run: {Path(error.filename).name} is missing"
            ) from error
        except (OSError, KeyError, ValueError) as error:
            raise ValueError(f"{out} cannot be read as a results folder: {error}") from error
        if len(patches) != len(utility.mean):
            raise ValueError(f"{out} holds a ranking of other places than its own: run the study again")
        return cls(out, utility, patches, clips, config["parameters"])

    @classmethod
    def of(cls, study: Study) -> FinishedStudy:
        """A study that has just been ranked; its features are on disk."""
        used = [outcome.clip for outcome in study.used]
        first = [used[int(np.argmax(study.groups == group))].name for group in study.groups]
        clips = tuple(
            FinishedClip(clip.name, clip.activity, clip.subject, motion)
            for clip, motion in zip(used, first, strict=True)
        )
        utility = study.recommendation.utility
        return cls(study.out, utility, study.patches, clips, study.config.as_dict())

    def config(self) -> StudyConfig:
        """The parameters of the run."""
        given = {**plain(StudyConfig()), **self.parameters}
        given = {item.name: given[item.name] for item in fields(StudyConfig)}
        given["synthesis"] = Synthesis(
            **given["synthesis"] | {"gravity": tuple(given["synthesis"]["gravity"])}
        )
        given["windows"] = WindowSpec(**given["windows"])
        wishes = {name: tuple(given["constraints"][name]) for name in ("only", "forbid", "must")}
        costs = tuple((words, cost) for words, cost in given["constraints"]["costs"])
        given["constraints"] = Constraints(**wishes, costs=costs)
        if given["augmentation"] is not None:
            given["augmentation"] = Augmentation(**given["augmentation"])
        return StudyConfig(**given)

    def body(self) -> Body:
        """The body of the study."""
        return Body.load(self.out / WORK / "body.npz")

    @cached_property
    def windows(self) -> tuple[ClipWindows, ...]:
        """The windows of each clip."""
        return tuple(ClipWindows(self.out, clip.name) for clip in self.clips)

    def inputs(self, classifier: str) -> PlaceBlocks:
        """What a classifier takes of the run: all windows of all places and copies, served from disk."""
        return ranking_inputs(
            self.out,
            [clip.name for clip in self.clips],
            self.windows,
            classifier,
            WindowSpec(**self.parameters["windows"]),
        )


def _clips(used: list[dict[str, Any]]) -> tuple[FinishedClip, ...]:
    name_of = {entry["file"]: entry["clip"] for entry in used}
    return tuple(
        FinishedClip(
            entry["clip"],
            entry["activity"],
            entry["subject"],
            name_of[entry.get("same_motion_as", entry["file"])],
        )
        for entry in used
    )


AT_MOST = 6
"""Sensors that are tested together: the classifier's width grows with each."""


def sensors_together(study: FinishedStudy, order: Sequence[int]) -> tuple[UtilityMap, ...]:
    """Test the first sensor alone, the first two together, and so on, up to `AT_MOST`.

    Parameters
    ----------
    study : FinishedStudy
    order : sequence of int
        Places as chosen.

    Returns
    -------
    tuple of UtilityMap
        Each of one place: the sensors side by side, by the folds of the run and its classifier. Of
        one that takes windows, that is a network of 6 channels a sensor.
    """
    classifier = study.parameters["classifier"]
    windows = [len(found.is_test) for found in study.windows]
    maps = multi_sensor_check(
        order[:AT_MOST],
        study.inputs(classifier),
        np.repeat([clip.activity for clip in study.clips], windows),
        clip=np.repeat([clip.motion for clip in study.clips], windows),
        subject=np.repeat([clip.subject for clip in study.clips], windows)
        if study.parameters["by_subject"]
        else None,
        is_test=np.concatenate([found.is_test for found in study.windows]),
        activities=sorted({clip.activity for clip in study.clips}),
        classifier=classifier,
        folds=study.parameters["folds"],
        seed=study.parameters["seed"],
    )
    return tuple(maps)
