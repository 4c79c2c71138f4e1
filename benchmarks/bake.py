# SPDX-License-Identifier: GPL-3.0-or-later
"""How fast the patches of a moving body are baked, against reading Blender's empties one by one.

Run it as `python benchmarks/bake.py`; it prints frames a second of each way and how many times
the naive loop that is, all in one run, the best of several rounds each, and ends with exit status
1 where a factor is below its aim for Blender 4.5. With `--library FOLDER` it goes on to real FBX
files: from file to signals on all patches, import included, against Blender's Python importer
alone on the same files.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from w2w.core.body.body import N_JOINTS, Body
from w2w.core.imu.presets import DEFAULT_SENSOR, preset
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import patch_matrices
from w2w.core.motion.source import UnusableMotion
from w2w.core.patches.patches import PatchSet, sample_patches
from w2w.core.reading.clips import to_body
from w2w.core.reading.formats import read_motion
from w2w.scene.bake import PatchBaker
from w2w.scene.base.actions import show_action, write_action
from w2w.scene.base.body import add_body
from w2w.scene.base.patches import patch_empties, place_patches
from w2w.scene.base.playback import each_frame
from w2w.scene.base.steps import without_pauses
from w2w.scene.heatmap import add_heatmaps, show_heatmap
from w2w.scene.motion.load import read_by_blender

RATE = 24.0
AIMS = {"general path": 9.0, "fast path, from the action": 60.0, "fast path, from a Motion": 100.0}
"""Times the naive loop of Blender 4.5; 5.0 reads an object's matrix some seven times faster."""

MAX_SWITCH = 0.016
SHARE = 0.5
"""Seconds that each way gets in a round at least, so that a short one is not judged by one bad moment."""


def main() -> int:
    """Measure, print, and tell by the exit status whether all aims are met."""
    options = _options()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    body = Body.bundled()
    patches = sample_patches(body, options.patches)
    motion = _swinging(body, options.frames)
    objects = add_body(body)
    show_action(objects.armature, write_action(objects.armature, motion))
    empties = patch_empties(place_patches(objects.mesh, patches))
    baker = PatchBaker(objects.mesh, patches)
    frames = 1.0 + np.arange(options.frames)
    ways: dict[str, Callable[[], object]] = {
        "empties, one by one": lambda: _read_empties(empties, frames),
        "general path": lambda: _general(baker),
        "fast path, from the action": lambda: without_pauses(baker.by_frame()).matrices,
        "fast path, from a Motion": lambda: patch_matrices(body, patches.triangles, motion),
    }
    seconds = _best_of_rounds(ways, options.rounds)
    print(f"Blender {bpy.app.version_string}: {options.frames} frames x {options.patches} patches")
    met = _report(seconds, options.frames)
    switch = _switch_seconds(objects.mesh, patches)
    print(f"{'heatmap switch':<28}{switch * 1000:9.2f} ms (aim {MAX_SWITCH * 1000:.0f} ms)")
    met &= switch < MAX_SWITCH
    if options.library is not None:
        met &= _bake_library(options.library, body, patches, options.rounds)
    return 0 if met else 1


def _general(baker: PatchBaker) -> np.ndarray:
    with mock.patch("w2w.scene.bake.why_not_fast", return_value="asked for"):
        return without_pauses(baker.by_frame()).matrices


def _read_empties(empties: list[bpy.types.Object], frames: np.ndarray) -> np.ndarray:
    matrices = np.empty((len(frames), len(empties), 4, 4))
    for number in each_frame(frames):
        matrices[number] = [np.array(empty.matrix_world) for empty in empties]
    return matrices


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--patches", type=int, default=512)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--library", type=Path, help="folder of FBX files")
    return parser.parse_args()


def _swinging(body: Body, n_frames: int) -> Motion:
    """Every joint swings at a rate of its own while the body walks on."""
    generator = np.random.default_rng(0)
    seconds = np.arange(n_frames) / RATE
    axes = generator.normal(size=(N_JOINTS, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    angles = 0.5 * np.sin(2 * np.pi * seconds[:, None] * generator.uniform(0.3, 1, N_JOINTS))
    turns = Rotation.from_rotvec((angles[..., None] * axes).reshape(-1, 3)).as_matrix()
    path = np.stack([0.2 * seconds, np.zeros(n_frames), 0.03 * np.sin(9 * seconds)], axis=1)
    return Motion(turns.reshape(n_frames, N_JOINTS, 3, 3), body.joints[0] + path, RATE)


def _best_of_rounds(ways: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Least seconds of each way; rounds go through all ways, so that a busy machine slows all alike."""
    best = dict.fromkeys(ways, np.inf)
    for _ in range(rounds):
        for name, way in ways.items():
            end = time.perf_counter() + SHARE
            while True:
                start = time.perf_counter()
                way()
                now = time.perf_counter()
                best[name] = min(best[name], now - start)
                if now > end:
                    break
    return best


def _report(seconds: dict[str, float], n_frames: int) -> bool:
    naive = next(iter(seconds.values()))
    met = True
    for name, value in seconds.items():
        factor, aim = naive / value, AIMS.get(name) if bpy.app.version < (5,) else None
        met &= aim is None or factor >= aim
        note = "" if aim is None else f" (aim {aim:.0f})"
        print(f"{name:<28}{value * 1000:9.1f} ms{n_frames / value:9.0f} frames/s{factor:8.1f} x{note}")
    return met


def _switch_seconds(mesh: bpy.types.Object, patches: object) -> float:
    """Median time to show another heatmap, the dependency graph brought up to date."""
    scores = np.random.default_rng(1).uniform(size=(len(patches), 4))
    names = add_heatmaps(mesh, patches, scores, ("a", "b", "c", "d"), scores.mean(axis=1))
    seconds = []
    for name in names * 4:
        start = time.perf_counter()
        show_heatmap(mesh, name)
        bpy.context.view_layer.update()
        seconds.append(time.perf_counter() - start)
    return float(np.median(seconds))


def _bake_library(folder: Path, body: Body, patches: PatchSet, rounds: int) -> bool:
    """Bake a folder of FBX files from file to signals, against Blender's Python importer alone."""
    bpy.ops.preferences.addon_enable(module="io_scene_fbx")
    paths = [path for path in sorted(folder.rglob("*.fbx")) if _is_usable(path)]
    ways: dict[str, Callable[[Path], object]] = {
        "Python importer alone": _import_by_python,
        "import and patch matrices": lambda path: _to_matrices(path, body, patches),
        "import, matrices and signals": lambda path: _to_signals(path, body, patches),
    }
    best = {name: dict.fromkeys(paths, np.inf) for name in ways}
    for _ in range(rounds):
        for path in paths:
            for name, way in ways.items():
                start = time.perf_counter()
                way(path)
                best[name][path] = min(best[name][path], time.perf_counter() - start)
                _clear()
    alone = sum(best["Python importer alone"].values())
    print(f"library of {len(paths)} FBX files")
    for name, seconds in best.items():
        total = sum(seconds.values())
        print(f"{name:<28}{total * 1000:9.0f} ms{total / alone:8.2f} of the Python importer's time")
    return sum(best["import and patch matrices"].values()) <= alone


def _is_usable(path: Path) -> bool:
    """Whether both importers read it; Blender's Python one stumbles over some files that ours reads."""
    try:
        read_motion(path, blender=read_by_blender)
        _import_by_python(path)
    except (UnusableMotion, RuntimeError):
        return False
    finally:
        _clear()
    return True


def _import_by_python(path: Path) -> None:
    bpy.ops.import_scene.fbx(filepath=str(path), use_image_search=False)


def _to_matrices(path: Path, body: Body, patches: PatchSet) -> tuple[np.ndarray, float]:
    motion = to_body(read_motion(path, blender=read_by_blender), body).motion
    return patch_matrices(body, patches.triangles, motion), motion.rate


def _to_signals(path: Path, body: Body, patches: PatchSet) -> ImuRecording:
    matrices, rate = _to_matrices(path, body, patches)
    ideal = synthesize(matrices, rate, Synthesis())
    return preset(DEFAULT_SENSOR).apply(ideal, seed=0)


def _clear() -> None:
    """Remove what an import left."""
    data = bpy.data
    bpy.data.batch_remove([*data.objects, *data.armatures, *data.meshes, *data.actions, *data.materials])


if __name__ == "__main__":
    sys.exit(main())
