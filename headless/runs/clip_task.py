# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip's task, as a worker gets it, and its result, as it comes back."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from w2w.core.clip_files import WORK, features_file, motion_file, signals_file
from w2w.core.files import UNFINISHED, file_sha256
from w2w.core.keypoints.facts import PoseFacts, side_car
from w2w.core.keypoints.pose_files import NO_FACTS
from w2w.core.motion.asf_amc import AMC_SUFFIX, skeleton_file
from w2w.core.motion.bone_maps import BoneMap
from w2w.core.motion.joint_files import is_joint_file
from w2w.core.motion.library import Clip
from w2w.core.motion.source import UnusableMotion
from w2w.core.study import StudyConfig

from .guard import LIMIT_S, MEMORY


@dataclass(frozen=True)
class ClipTask:
    """All that a worker needs to know about one clip.

    Parameters
    ----------
    clip : Clip
    out : Path
        The study's output folder.
    config : StudyConfig
    inputs : str
        Hash of the body, the patches, the config and the code that the result depends on.
    limit_s : float
        Seconds after which a worker gives the clip up.
    bone_maps : tuple of BoneMap
        The user's own, tried before the bundled ones.
    memory : int
        Bytes that a worker may take.
    pose : PoseFacts
        What is known of joint positions from video.
    """

    clip: Clip
    out: Path
    config: StudyConfig
    inputs: str
    limit_s: float = LIMIT_S
    bone_maps: tuple[BoneMap, ...] = ()
    memory: int = MEMORY
    pose: PoseFacts = NO_FACTS

    @property
    def motion_file(self) -> Path:
        """The retargeted motion."""
        return motion_file(self.out, self.clip.name)

    @property
    def signals_file(self) -> Path:
        """The recording of all patches."""
        return signals_file(self.out, self.clip.name)

    @property
    def features_file(self) -> Path:
        """Windows as features, for the ranking."""
        return features_file(self.out, self.clip.name)

    @property
    def record_file(self) -> Path:
        """What was done, and from what: written before the files get their names."""
        return record_file(self.out, self.clip.name)

    @property
    def marker(self) -> Path:
        """There while a worker is at it."""
        return self.out / WORK / "running" / self.clip.name

    def key(self, source_sha256: str) -> str:
        """Hash of everything that the result depends on."""
        parts = [self.inputs, source_sha256, self.clip.activity, self.clip.subject, self.clip.name]
        parts += [file_sha256(path) for path in _read_beside(self.clip.path)]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _read_beside(path: Path) -> list[Path]:
    """Files that say what the clip's own does not: its skeleton, or its rate and joints."""
    if path.suffix.lower() == AMC_SUFFIX:
        try:
            return [skeleton_file(path)]
        except UnusableMotion:
            return []
    beside = side_car(path) if is_joint_file(path) else None
    return [] if beside is None else [beside]


def record_file(out: Path, clip: str) -> Path:
    """The record of a clip in a results folder."""
    return out / WORK / "clips" / f"{clip}.json"


def unfinished(path: Path) -> Path:
    """Where a motion or recording stands until the clip's record names it."""
    return path.with_name(f".{path.name}{UNFINISHED}")
