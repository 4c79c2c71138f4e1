# SPDX-License-Identifier: GPL-3.0-or-later
"""Any motion file to a motion on the body, whatever wrote it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from ..core.body.body import Body
from ..core.motion.bone_maps import BoneMap
from ..core.motion.motion import SMPL_SUFFIXES, Motion, read_amass
from ..core.motion.retarget import retarget
from ..core.motion.skinning import on_the_ground
from ..core.motion.source import SourceMotion


class Carried(NamedTuple):
    """A motion on the body, and where it came from.

    Attributes
    ----------
    motion : Motion
        Without labels.
    take : str
        Name of the take; empty for SMPL files, which have none.
    skeleton : str
        Whose bone names matched.
    scale : float
        Body metres in one unit of the file.
    """

    motion: Motion
    take: str
    skeleton: str
    scale: float


def read_motion(path: Path) -> SourceMotion | Motion:
    """Read a motion file: a named skeleton through Blender, or an SMPL motion directly.

    Raises
    ------
    UnusableMotion
        If it cannot be used; the message says why.
    """
    if path.suffix.lower() in SMPL_SUFFIXES:
        return read_amass(path)
    from .takes import read_clip

    return read_clip(path)


def carry(source: SourceMotion | Motion, body: Body, maps: Sequence[BoneMap] = ()) -> Carried:
    """Retarget what a file holds to a body.

    Parameters
    ----------
    source : SourceMotion or Motion
        From `read_motion`.
    body : Body
    maps : sequence of BoneMap
        The user's own, tried before the bundled ones.

    Raises
    ------
    UnusableMotion
        If the skeleton cannot be matched.
    """
    if isinstance(source, Motion):
        return Carried(on_the_ground(body, source), "", "SMPL", 1.0)
    carried = retarget(source, body, maps)
    return Carried(carried.motion, source.take, carried.bone_map, carried.scale)
