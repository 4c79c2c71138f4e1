# SPDX-License-Identifier: GPL-3.0-or-later
"""The road of one clip, from its FBX file to its signals on disk, beside Blender's importer in Python."""

from __future__ import annotations

import functools
import statistics
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest import mock

from tests.robustness.fbx_variants import LABELS
from w2w.core.body.body import Body
from w2w.core.library.library import read_library
from w2w.core.reading.guard import quiet_output
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import place_patches
from w2w.headless.runs import clip as clip_work, clip_task
from w2w.headless.runs.clip import WORK, do_clip
from w2w.headless.runs.clip_task import ClipTask
from w2w.headless.runs.folder import make_folders


def road(folder: Path, files: int) -> None:
    """Print the ratio of our whole road to a mere import, and where our time goes."""
    import bpy

    clips = read_library(folder, folder / LABELS).clips
    clips = clips[:: max(1, len(clips) // files)][:files]
    config = StudyConfig()
    ours, theirs, features = [], [], []
    stages: dict[str, float] = defaultdict(float)
    with tempfile.TemporaryDirectory() as place, ExitStack() as patched:
        out = Path(place)
        _prepare(out, config)
        do_clip(ClipTask(clips[0], out, config, "to warm up"))
        for target, name, stage in _stages():
            patched.enter_context(
                mock.patch.object(target, name, _timed(getattr(target, name), stage, stages))
            )
        for clip in clips:
            before = stages["features for the ranking"]
            start = time.perf_counter()
            result = do_clip(ClipTask(clip, out, config, "road"))
            seconds = time.perf_counter() - start
            if result["reason"]:
                continue
            ours.append(seconds)
            features.append(stages["features for the ranking"] - before)
            theirs.append(_import_only(bpy, clip.path))
    whole, mere = sum(ours), sum(theirs)
    to_signals = whole - sum(features)
    print(f"{len(ours)} files; median clip {1000 * statistics.median(ours):.0f} ms")
    print(f"file to stored signals   {1000 * to_signals / len(ours):6.1f} ms a clip")
    print(f"import_scene.fbx alone   {1000 * mere / len(ours):6.1f} ms a clip")
    print(f"ratio {to_signals / mere:.2f}; with the features for the ranking {whole / mere:.2f}")
    print("\nwhere the time goes              ms a clip   share")
    for stage, seconds in sorted(stages.items(), key=lambda item: -item[1]):
        print(f"{stage:32s} {1000 * seconds / len(ours):8.1f}   {100 * seconds / whole:4.0f} %")
    rest = whole - sum(stages.values())
    print(f"{'the rest':32s} {1000 * rest / len(ours):8.1f}   {100 * rest / whole:4.0f} %")


def _prepare(out: Path, config: StudyConfig) -> None:
    make_folders(out)
    body = Body.bundled()
    body.save(out / WORK / "body.npz")
    place_patches(body, config).save(out / WORK / "patches.npz")


def _stages() -> list[tuple[Any, str, str]]:
    """Functions whose time counts as a stage; none calls another of them."""
    from w2w.core.imu import virtual as virtual_imu
    from w2w.core.imu.recording import ImuRecording
    from w2w.core.imu.sensor import SensorModel
    from w2w.core.motion.motion import Motion
    from w2w.scene.motion import load as motions, takes as clips

    return [
        (clips, "import_file", "Blender's import, in C++"),
        (clips, "best_take", "f-curves to bone matrices"),
        (clips, "existing_data", "cleaning Blender"),
        (clips, "new_data", "cleaning Blender"),
        (motions, "retarget", "retargeting"),
        (virtual_imu, "synthesize", "skinning and ideal signals"),
        (SensorModel, "apply", "sensor errors"),
        (clip_work, "describe", "features for the ranking"),
        (Motion, "save", "writing the motion"),
        (ImuRecording, "save", "writing the signals"),
        (clip_work, "write_features", "writing the features"),
        (clip_task, "file_sha256", "hashes"),
        (clip_task, "write_json", "writing the record"),
        (virtual_imu, "skinning_transforms", "kinematics"),
    ]


def _timed(function: Callable, stage: str, stages: dict[str, float]) -> Callable:
    @functools.wraps(function)
    def timed(*args: Any, **kwargs: Any) -> Any:
        start = time.perf_counter()
        try:
            return function(*args, **kwargs)
        finally:
            stages[stage] += time.perf_counter() - start

    return timed


def _import_only(bpy: Any, path: Path) -> float:
    """Seconds that `import_scene.fbx` takes, in a file with nothing else in it."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    start = time.perf_counter()
    with quiet_output():
        bpy.ops.import_scene.fbx(filepath=str(path))
    seconds = time.perf_counter() - start
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    return seconds
