# SPDX-License-Identifier: GPL-3.0-or-later
"""Read one motion file in a worker process, so that one that crashes or hangs Blender is only a bad file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from blender_addon.w2w.core.body import Body
from blender_addon.w2w.core.bone_maps import BoneMap
from blender_addon.w2w.core.library import Clip
from blender_addon.w2w.core.motion import Motion
from blender_addon.w2w.core.motion_file import unreadable
from blender_addon.w2w.core.source_motion import SourceMotion, UnusableMotion, reason_of

from .engine import run_alone
from .load_clip import load_clip
from .needs_blender import NoBlenderError
from .worker_guard import LIMIT_S, MEMORY, guarded

Loaded = tuple[SourceMotion | Motion, Motion, dict[str, Any]]


def load_alone(clip: Clip, body: Body, bone_maps: Sequence[BoneMap] = ()) -> Loaded:
    """What `load_clip` gives, whatever the file does to the process that reads it.

    Raises
    ------
    UnusableMotion
        If it cannot be used; the message says why.
    NoBlenderError
        If it needs Blender, and Blender's module cannot be imported.
    """
    found = run_alone(_load, clip, body, tuple(bone_maps))
    if found is None:
        raise UnusableMotion(
            f"Blender crashed on it, or it took longer than {LIMIT_S:g} s or more than "
            f"{MEMORY / 2**30:g} GiB: it is damaged, or far too long"
        )
    if isinstance(found, str):
        raise UnusableMotion(found)
    return found


def _load(clip: Clip, body: Body, bone_maps: Sequence[BoneMap]) -> Loaded | str:
    """The clip, or a sentence."""
    with guarded():
        try:
            return load_clip(clip, body, bone_maps)
        except NoBlenderError:
            raise
        except MemoryError:
            return f"it needs more than {MEMORY / 2**30:g} GiB of memory"
        except OSError as error:
            return unreadable(error)
        except (UnusableMotion, ValueError) as error:
            return reason_of(error)
        except Exception as error:
            return f"W2W failed on it, please report this: {type(error).__name__}: {error}"
