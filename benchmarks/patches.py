# SPDX-License-Identifier: GPL-3.0-or-later
"""How fast and how true patches are sampled, against a loop over the heat method.

Run it as `python benchmarks/patches.py [--body BODY.npz]`. All figures come from one run, each time
the best of several rounds of processor time; it ends with exit status 1 where an aim is missed:
512 patches in under 3 s, sampling no slower than the heat loop and with less error, and a heatmap
switched in under a millisecond.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import potpourri3d
from pygeodesic.geodesic import PyGeodesicAlgorithmExact
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from w2w.core.body.body import BUNDLED_BODY, Body
from w2w.core.patches.carriers import MIN_HEIGHT, random_poses, triangle_rotation_error
from w2w.core.patches.patches import farthest_points, sample_patches
from w2w.core.patches.strip_graph import StripGraph

PATCHES = 512
MOST_SECONDS = 3.0
MOST_SWITCH = 1e-3
TRIED_POSES, TRIED_SEED = 200, 99
"""Poses that the triangles are judged by; others than those they were chosen by."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--body", type=Path, default=BUNDLED_BODY, help="npz of a body; the bundled one by default"
    )
    parser.add_argument("--rounds", type=int, default=3, help="rounds, of which the best counts")
    options = parser.parse_args()
    body = Body.load(options.body)
    print(f"{body.name}: {len(body.vertices)} vertices, {PATCHES} patches")
    with threadpool_limits(1):  # threads that wait for each other would count as processor time
        missed = [*_distances(body), *_sampling(body, options.rounds), *_spreading(body, options.rounds)]
        _triangles(body)
    for aim in missed:
        print(f"MISSED: {aim}")
    return 1 if missed else 0


def _distances(body: Body) -> list[str]:
    """Error of approximate distances against exact ones, over sources all over the body."""
    exact = PyGeodesicAlgorithmExact(body.vertices, body.faces)
    heat = potpourri3d.MeshHeatMethodDistanceSolver(body.vertices, body.faces)
    strips, edges = (StripGraph.of(body.vertices, body.faces, crossings) for crossings in (3, 0))
    sources = np.random.default_rng(0).integers(len(body.vertices), size=12).tolist()
    truth = np.array([exact.geodesicDistances([source], None)[0] for source in sources])
    found = {
        "Dijkstra on edges": np.array([edges.distances(source) for source in sources]),
        "heat method": np.array([heat.compute_distance(source) for source in sources]),
        "strip graph": np.array([strips.distances(source) for source in sources]),
    }
    away = truth > 0
    mean = {}
    print("error of distances (mean, 99th percentile):")
    for name, values in found.items():
        error = np.abs(values[away] / truth[away] - 1)
        mean[name] = error.mean()
        print(f"  {name:28s} {100 * mean[name]:5.2f} % {100 * np.percentile(error, 99):6.2f} %")
    worse = mean["strip graph"] >= mean["heat method"]
    return ["distances are no truer than the heat method's"] if worse else []


def _sampling(body: Body, rounds: int) -> list[str]:
    """Time of sampling alone, set-up included, and of everything that makes a `PatchSet`."""
    vertices, faces = body.vertices, body.faces

    def graph(n: int = PATCHES) -> np.ndarray:
        return farthest_points(StripGraph.of(vertices, faces), n, 0)

    spent = {
        "heat method, plain loop": _seconds(lambda: _by_heat(vertices, faces), rounds),
        "strip graph": _seconds(graph, rounds),
        "strip graph, 2,048": _seconds(lambda: graph(2048), 1),
        "all of sample_patches": _seconds(lambda: sample_patches(body, PATCHES), rounds),
        "all of sample_patches, seed 1": _seconds(lambda: sample_patches(body, PATCHES, 1), rounds),
    }
    print("farthest-point sampling (s):")
    for name, seconds in spent.items():
        print(f"  {name:28s} {seconds:7.2f}")
    missed = []
    if spent["all of sample_patches, seed 1"] > MOST_SECONDS:
        missed.append(f"patches take more than {MOST_SECONDS:g} s")
    if spent["strip graph"] > spent["heat method, plain loop"]:
        missed.append("sampling is slower than the heat loop")
    return missed


def _spreading(body: Body, rounds: int) -> list[str]:
    """Time of one heatmap, and how well waves across the body are found again from their patches."""
    patches = sample_patches(body, PATCHES)
    scores = np.random.default_rng(0).random(PATCHES)
    seconds = _seconds(lambda: [patches.to_vertices(scores) for _ in range(100)], rounds) / 100
    print(f"scores to vertices: {1e3 * seconds:.3f} ms; error on waves (of their own deviation):")
    directions = np.random.default_rng(1).normal(size=(3, 20))
    directions /= np.linalg.norm(directions, axis=0)
    for length in (0.8, 0.4, 0.25):
        waves = np.sin(2 * np.pi / length * body.vertices @ directions + np.arange(20))
        known = waves[patches.vertices]
        spread, cells = (
            (np.std(found - waves, axis=0) / waves.std(axis=0)).mean()
            for found in (patches.to_vertices(known), known[patches.labels])
        )
        print(f"  {length:4.2f} m long: {100 * spread:4.1f} %, one value a cell {100 * cells:4.1f} %")
    return ["scores to vertices take more than a millisecond"] if seconds > MOST_SWITCH else []


def _triangles(body: Body) -> None:
    """Worst rotation of the patches' triangles against their bones, next to the nearest vertices."""
    patches = sample_patches(body, PATCHES)
    graph = StripGraph.of(body.vertices, body.faces)
    nearest = np.array([near[:3] for near in graph.neighbourhoods(patches.vertices, 0.04, 3)])
    poses = random_poses(TRIED_POSES, TRIED_SEED)
    print(f"worst rotation against the bone over {TRIED_POSES} poses (degrees):")
    for name, triangles in (("three nearest vertices", nearest), ("chosen triangles", patches.triangles)):
        worst = np.degrees(triangle_rotation_error(body, triangles, poses))
        middle, high, extreme = np.percentile(worst, [50, 90, 99])
        low = int((_heights(body, triangles) < MIN_HEIGHT).sum())
        print(f"  {name:28s} median {middle:.1f}, 90 % {high:.1f}, 99 % {extreme:.1f}, all {worst.max():.1f}")
        print(f"  {'':28s} {int((worst > 60).sum())} over 60, {low} lower than 4 mm")


def _by_heat(vertices: np.ndarray, faces: np.ndarray) -> list[int]:
    """Farthest points by the heat method, which always solves for the whole mesh."""
    solver, picks, distance = potpourri3d.MeshHeatMethodDistanceSolver(vertices, faces), [0], np.inf
    while len(picks) < PATCHES:
        distance = np.minimum(distance, solver.compute_distance(picks[-1]))
        picks.append(int(np.argmax(distance)))
    return picks


def _heights(body: Body, triangles: np.ndarray) -> np.ndarray:
    corners = body.vertices[triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    double_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return double_area / np.linalg.norm(sides, axis=2).max(axis=1)


def _seconds(task: Callable[[], Any], rounds: int) -> float:
    """Least processor time of several rounds."""
    spent = []
    for _ in range(rounds):
        begin = time.process_time()
        task()
        spent.append(time.process_time() - begin)
    return min(spent)


if __name__ == "__main__":
    sys.exit(main())
