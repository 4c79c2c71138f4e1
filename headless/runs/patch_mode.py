# SPDX-License-Identifier: GPL-3.0-or-later
"""Which way patches can be placed with the libraries that are here."""

from __future__ import annotations

from dataclasses import replace

from rich.console import Console

from w2w.core.patches.geodesics import exact_is_available
from w2w.core.study import StudyConfig


def placeable(config: StudyConfig, console: Console) -> StudyConfig:
    """The config, with patches placed in mode "fast" where exact geodesics lack their library; says so."""
    if config.patch_mode != "exact" or exact_is_available():
        return config
    console.print(
        "Patches are placed in mode 'fast': pygeodesic, the library of exact distances, is not there for "
        "this Python. Where it is there, patches are not quite at the same places."
    )
    return replace(config, patch_mode="fast")
