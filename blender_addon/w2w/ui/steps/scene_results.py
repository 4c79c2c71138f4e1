# SPDX-License-Identifier: GPL-3.0-or-later
"""A ranked study in the scene, as core reads one from a results folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ...core.body.body import Body
from ...core.study.results import StudyResults


@dataclass(frozen=True, eq=False)
class SceneResults(StudyResults):
    """A finished study that is in the scene; the files of its clips may lie in several folders."""

    stored: tuple[tuple[Path, str], ...]
    shown: Body

    @property
    def places(self) -> tuple[tuple[Path, str], ...]:
        """Folder of each clip's files, and their name in it."""
        return self.stored

    def body(self) -> Body:
        """The body of the study."""
        return self.shown

    def renamed(self, names: Sequence[str]) -> SceneResults:
        """The same with other names of the clips."""
        name_of = dict(zip((clip.name for clip in self.clips), names, strict=True))
        pairs = zip(self.clips, names, strict=True)
        clips = (replace(clip, name=name, motion_key=name_of[clip.motion_key]) for clip, name in pairs)
        return replace(self, clips=tuple(clips))
