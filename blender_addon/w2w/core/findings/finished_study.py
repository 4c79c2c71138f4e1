# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished study, ready to be written down: by the command line, or from Blender's panel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..body.body import Body
from ..clip_ranking import copies_among
from ..motion.library import Clip, Library
from ..results_folder import StudyResults
from ..selection.advice import Advice
from ..study import StudyConfig


@dataclass(frozen=True)
class ClipResult:
    """A clip, used or skipped."""

    clip: Clip
    reason: str  # why it was skipped; empty where it is used
    details: dict[str, Any]  # of a used clip: take, frames, rate, duration, windows, skeleton
    source_sha256: str  # of the clip's file

    @property
    def used(self) -> bool:
        """Whether the clip takes part in the ranking."""
        return not self.reason


@dataclass(frozen=True)
class Study:
    """A finished study, ready to be written down."""

    library: Library
    config: StudyConfig
    body: Body
    clips: tuple[ClipResult, ...]  # all of them, in the library's order
    results: StudyResults  # the ranking, as it is read again from its folder
    advice: Advice  # the choice under the config's constraints

    @property
    def used(self) -> list[ClipResult]:
        """Clips that take part."""
        return [result for result in self.clips if result.used]

    @property
    def copies(self) -> list[tuple[str, str]]:
        """Files that show the motion of another, each with the first that shows it."""
        return copies_among([result.clip for result in self.used], self.results.clips)
