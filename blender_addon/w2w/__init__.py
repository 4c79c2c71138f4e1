# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W, "Where to Wear": where on the body a motion sensor recognises activities best.

One package for two uses. Blender calls `register` and `unregister`; everyone else writes::

    import w2w

    motions = w2w.load("MY_CLIPS")
    patches = w2w.sample_patches(w2w.Body.bundled())
    signals = w2w.synthesize(motions, patches, sensor="bmi270")
    ranking = w2w.rank(signals)
    ranking.best, ranking.wear_together(0.9), ranking.heatmap("best.png")

Names are imported when first used, so that Blender starts no slower for them.
"""

from __future__ import annotations

import atexit
import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # so that editors and type checkers see signatures
    from .api.loading import (
        from_joints as from_joints,
        from_smpl as from_smpl,
        load as load,
        load_body as load_body,
    )
    from .api.rank import rank as rank
    from .api.ranking import Ranking as Ranking
    from .api.signals import open_results as open_results, stream as stream, synthesize as synthesize
    from .core.body.body import Body as Body
    from .core.body.shapes import shaped as shaped
    from .core.imu.formats import read_recording as read_recording, write_recording as write_recording
    from .core.imu.presets import preset as preset, read_sensor as read_sensor
    from .core.imu.recording import ImuRecording as ImuRecording
    from .core.imu.recordings import Recordings as Recordings
    from .core.imu.sensor import SensorModel as SensorModel
    from .core.imu.synthesis import Synthesis as Synthesis
    from .core.keypoints.facts import PoseFacts as PoseFacts
    from .core.motion.motion import Motion as Motion
    from .core.patches.own_placements import patches_at as patches_at
    from .core.patches.patches import PatchSet as PatchSet, sample_patches as sample_patches
    from .core.ranking.agreement import rank_agreement as rank_agreement
    from .core.ranking.classifiers.estimator import EstimatorClassifier as EstimatorClassifier
    from .core.ranking.utility import UtilityMap as UtilityMap
    from .core.selection.constraints import Constraints as Constraints
    from .core.windows.windows import WindowSpec as WindowSpec

__version__ = "0.1.0"
"""The one place where it is written for pip; a test holds the other files to it."""

_NAMES = {
    "api.rank": ("rank",),
    "api.signals": ("open_results", "stream", "synthesize"),
    "core.body.body": ("Body",),
    "core.body.shapes": ("shaped",),
    "core.imu.formats": ("read_recording", "write_recording"),
    "core.imu.presets": ("preset", "read_sensor"),
    "core.imu.recording": ("ImuRecording",),
    "core.imu.recordings": ("Recordings",),
    "core.imu.sensor": ("SensorModel",),
    "core.imu.synthesis": ("Synthesis",),
    "core.keypoints.facts": ("PoseFacts",),
    "core.motion.motion": ("Motion",),
    "core.patches.own_placements": ("patches_at",),
    "core.patches.patches": ("PatchSet", "sample_patches"),
    "core.ranking.agreement": ("rank_agreement",),
    "core.ranking.classifiers.estimator": ("EstimatorClassifier",),
    "core.ranking.utility": ("UtilityMap",),
    "core.selection.constraints": ("Constraints",),
    "core.windows.windows": ("WindowSpec",),
    "api.loading": ("from_joints", "from_smpl", "load", "load_body"),
    "api.ranking": ("Ranking",),
}
"""Public names by their modules inside this package."""

_HOMES = {name: module for module, names in _NAMES.items() for name in names}

__all__ = [*sorted(_HOMES), "__version__"]


if not TYPE_CHECKING:  # or a checker would take any name for one of these

    def __getattr__(name: str) -> Any:
        """Import a public name when it is first asked for."""
        if name not in _HOMES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__} - {"register", "unregister"})  # those are Blender's


def register() -> None:
    """Register everything with Blender."""
    from . import command_line, ui

    ui.register()
    command_line.register()
    # Blender's Python module hangs at its exit where classes are still registered
    atexit.register(unregister)


def unregister() -> None:
    """Take back what `register` did."""
    from . import command_line, ui

    atexit.unregister(unregister)
    command_line.unregister()
    ui.unregister()
