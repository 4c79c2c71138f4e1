# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameters of a study with one more, added as ARCHITECTURE says."""

from dataclasses import dataclass

from w2w.core.parameters import parameter
from w2w.core.study.config import StudyConfig


@dataclass(frozen=True)
class WithDrift(StudyConfig):
    """A study's parameters and one that nothing else in W2W knows."""

    drift: float = parameter(0.0, "Drift of the clock, parts per million.", least=0)
