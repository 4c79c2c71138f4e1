# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of some clips at some patches, of which a run without signals keeps what the next one needs."""

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from ..files import load_arrays, write_npz
from ..given import inside
from ..imu.recording import ImuRecording
from ..threads import for_each
from .clip_files import WORK, signals_file, signals_key
from .results import SimulatedClips

REMADE = f"{WORK}/remade.npz"
"""What patches recorded of clips, by names of the clips and keys of their files."""


def recordings_at(study: SimulatedClips, clips: Sequence[int], patches: Sequence[int]) -> list[ImuRecording]:
    """Recordings of clips, by number, at some patches; those made again as kept by an earlier run.

    A run keeps those at the patches that it asks for first.
    """
    keep = study.read is not None
    if signals_file(*study.places[clips[0]]).exists():
        if keep:
            inside(study.out, REMADE).unlink(missing_ok=True)
        return for_each(lambda clip: study.recording(clip, patches), clips)
    file = inside(study.out, REMADE)
    keys = [f"{study.clips[clip].name} {signals_key(*study.places[clip])}" for clip in clips]
    clip_of = dict(zip(keys, clips, strict=True))
    held: dict[str, ImuRecording] = {}
    before: list[str] = []
    with suppress(OSError, ValueError, TypeError, IndexError):  # damaged: all are made again
        kept = load_arrays(file, ("keys", "ends", "patches", "values"), "holds no recordings")
        names, parts = kept["keys"].tolist(), np.split(kept["values"], kept["ends"])
        if kept["patches"].tolist() == list(patches):
            held = {
                key: study.recorded(clip_of[key], patches, part[..., :3], part[..., 3:])
                for key, part in zip(names, parts, strict=True)
                if key in clip_of
            }
        before = names

    def recorded(pair: tuple[str, int]) -> ImuRecording:
        return held[pair[0]] if pair[0] in held else study.recording(pair[1], patches)

    found = for_each(recorded, list(zip(keys, clips, strict=True)))
    if keep and keys != before:
        values = np.concatenate([one.values[..., :6] for one in found])
        ends = np.cumsum([one.n_samples for one in found])[:-1]
        write_npz(file, {"keys": keys, "ends": ends, "patches": patches, "values": values})
    return found
