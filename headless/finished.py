# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished results folder, read back so that its ranking can be used again without baking anything."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from blender_addon.w2w.core.body import Body
from blender_addon.w2w.core.clip_blocks import clip_inputs
from blender_addon.w2w.core.patches import PatchSet
from blender_addon.w2w.core.place_blocks import PlaceBlocks
from blender_addon.w2w.core.utility import UtilityMap
from blender_addon.w2w.core.windows import WindowSpec

from .clip_job import WORK
from .pipeline import Study

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
    windows : int
        Windows cut from it.
    """

    name: str
    activity: str
    subject: str
    motion: str
    windows: int


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
            FinishedClip(clip.name, clip.activity, clip.subject, motion, outcome.details["windows"])
            for clip, motion, outcome in zip(used, first, study.used, strict=True)
        )
        utility = study.recommendation.utility
        return cls(study.out, utility, study.patches, clips, study.config.as_dict())

    def body(self) -> Body:
        """The body of the study."""
        return Body.load(self.out / WORK / "body.npz")

    def inputs(self) -> PlaceBlocks:
        """What the run's classifier was trained on: all windows of all places, served from disk."""
        return clip_inputs(
            self.parameters["classifier"],
            self._features,
            [self.out / "signals" / f"{clip.name}.npz" for clip in self.clips],
            [clip.windows for clip in self.clips],
            WindowSpec(**self.parameters["windows"]),
        )

    def is_test(self) -> np.ndarray:
        """Windows that may be tested on, shape (W,)."""
        parts = []
        for path in self._features:
            with np.load(path, allow_pickle=False) as data:
                parts.append(data["is_test"])
        return np.concatenate(parts)

    @property
    def _features(self) -> list[Path]:
        return [self.out / WORK / "features" / f"{clip.name}.npz" for clip in self.clips]


def _clips(used: list[dict[str, Any]]) -> tuple[FinishedClip, ...]:
    name_of = {entry["file"]: entry["clip"] for entry in used}
    return tuple(
        FinishedClip(
            entry["clip"],
            entry["activity"],
            entry["subject"],
            name_of[entry.get("same_motion_as", entry["file"])],
            entry["windows"],
        )
        for entry in used
    )
