# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed of the classifiers: 512 places, 24 activities, 589 clips, about 3,000 windows, 5 folds.

    python -m benchmarks.utility_speed RESULTS [--sample 8] [--only map,networks] [--json OUT.json]

RESULTS is the folder of a finished `w2w run`. Its recordings of the activities with most motions are taken
again and again, every sensor turned anew each time as when it is put on again (10 degrees), until there
are 589. A motion and its copies stay in one fold, so that scores are honest, and as low as so few motions
make them.

"map" times features and the ridge map, and beside them the same protocol as a plain loop over
scikit-learn's ExtraTrees(100), on a sample of places, scaled linearly. Two such loops that differ by their
seed alone say how well any map can agree with one of them. "networks" times a step of
multi3net: the places one after another, under `torch.func.vmap`, and as the hand-written batched
program that is used; and "training" whole epochs with all that belongs to them, in turn and together.

Processor seconds count all threads: half of them is what two idle cores need. Wall-clock seconds beside them
tell how busy the machine was.
"""

from __future__ import annotations

import argparse
import os
import time
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.files import write_json
from w2w.core.imu.recording import ImuRecording
from w2w.core.ranking.agreement import rank_agreement
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.study.results import StudyResults
from w2w.core.windows.features import window_features
from w2w.core.windows.windows import WindowSpec, cut_windows
from w2w_studies.classifiers.multi3net.classifier import Multi3Net
from w2w_studies.classifiers.trees import extra_trees

ACTIVITIES = 24
CLIPS = 589
SPEC = WindowSpec(length_s=2.0, stride_s=0.5)
TURN_DEG = 10.0


def timed(work: Callable[[], Any]) -> tuple[Any, dict[str, float]]:
    """What work gives, and the processor and wall-clock seconds it took."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = work()
    return result, {
        "cpu_s": round(time.process_time() - cpu, 2),
        "wall_s": round(time.perf_counter() - wall, 2),
    }


def read_recordings(results: Path) -> list[tuple[ImuRecording, str, str]]:
    """Recordings of the activities with most motions, each with its activity and its motion."""
    study = StudyResults.load(results)
    motions = Counter(activity for activity, _ in {(clip.activity, clip.motion_key) for clip in study.clips})
    chosen = [name for name, _ in motions.most_common(ACTIVITIES)]
    return [
        (ImuRecording.load(results / "signals" / f"{clip.name}.npz"), clip.activity, clip.motion_key)
        for clip in study.clips
        if clip.activity in chosen
    ]


def remounted(recording: ImuRecording, rng: np.random.Generator) -> ImuRecording:
    """The recording with every sensor turned in its place, about a random axis."""
    turns = Rotation.from_rotvec(np.radians(TURN_DEG) * rng.normal(size=(recording.n_sensors, 3))).as_matrix()
    acc, gyr = (np.einsum("tni,nij->tnj", values, turns) for values in (recording.acc, recording.gyr))
    return replace(recording, acc=acc, gyr=gyr)


def make_library(results: Path) -> tuple[list[np.ndarray], float, dict[str, np.ndarray]]:
    """Windows of 589 clips, clip by clip, their rate, and the labels of each window."""
    found = read_recordings(results)
    rng = np.random.default_rng(0)
    windows, is_test, activity, motion = [], [], [], []
    for number in range(CLIPS):
        recording, name, group = found[number % len(found)]
        if number >= len(found):
            recording = remounted(recording, rng)
        cut = cut_windows(recording, SPEC)
        windows.append(cut.signals)
        is_test.append(cut.is_test)
        activity += [name] * len(cut.is_test)
        motion += [group] * len(cut.is_test)
    labels = {
        "activity": np.array(activity),
        "clip": np.array(motion),
        "is_test": np.concatenate(is_test),
    }
    return windows, found[0][0].rate, labels


def rank(features: np.ndarray, labels: dict[str, np.ndarray], classifier: Any) -> UtilityMap:
    """The map of some places."""
    activities = sorted(set(labels["activity"].tolist()))
    return utility_map(features, CrossValidation(**labels, subject=None, activities=activities), classifier)


def benchmark_map(
    windows: list[np.ndarray], rate: float, labels: dict[str, np.ndarray], sample: int
) -> dict[str, Any]:
    """Features, the ridge map of all places, and the loop of forests on a sample of them."""
    features, of_features = timed(lambda: np.concatenate([window_features(part, rate) for part in windows]))
    ridge, of_ridge = timed(lambda: rank(features, labels, "ridge"))
    places = np.linspace(0, features.shape[1] - 1, sample).round().astype(int)
    forests = replace(extra_trees(), workers=1)
    trees, of_trees = timed(lambda: rank(features[:, places], labels, forests))
    scale = features.shape[1] / sample
    others = rank(features[:, places], labels, replace(extra_trees(seed=1), workers=1))
    agreement = rank_agreement(
        ridge.mean[places], trees.mean, ridge.mean_samples[:, places], trees.mean_samples
    )
    ceiling = rank_agreement(others.mean, trees.mean, others.mean_samples, trees.mean_samples)
    return {
        "windows": len(features),
        "places": features.shape[1],
        "activities": len(ridge.activities),
        "features": of_features,
        "ridge_map": of_ridge,
        "forests_on_sample": of_trees,
        "sample": sample,
        "forests_scaled_cpu_s": round(of_trees["cpu_s"] * scale),
        "times_faster": round(of_trees["cpu_s"] * scale / of_ridge["cpu_s"], 1),
        "f1_ridge": round(float(ridge.mean[places].mean()), 4),
        "f1_forests": round(float(trees.mean.mean()), 4),
        "spearman": [round(value, 3) for value in (agreement.spearman, agreement.low, agreement.high)],
        "spearman_of_two_forests": [
            round(value, 3) for value in (ceiling.spearman, ceiling.low, ceiling.high)
        ],
    }


def benchmark_networks(windows: np.ndarray, classes: int, repeats: int = 5) -> dict[str, Any]:
    """Seconds of a step of multi3net a place: alone, under vmap, batched by hand; one thread."""
    import torch
    from torch.nn.functional import cross_entropy

    from w2w_studies.classifiers.multi3net.network import Examples, Network

    torch.set_num_threads(1)
    settings = Multi3Net()
    some = windows[: settings.batch, : settings.group]
    rows = np.arange(len(some))
    inputs = Examples.prepare(some, rows, rows, rows[:0], "cpu", settings.spectrum).windows
    network = Network(
        inputs.shape[1], inputs.shape[2], classes, settings.width, settings.hidden, settings.embedding
    )
    draws = torch.Generator().manual_seed(0)
    weights = network.initial(draws).repeat(len(inputs), 1)
    masks = network.masks(inputs.shape[3], draws)
    labels = torch.randint(classes, (inputs.shape[3],), generator=draws)

    def slopes(part: Any, signals: Any, forward: Callable[..., Any]) -> None:
        part = part.clone().requires_grad_()
        scores = forward(part, signals)
        loss = cross_entropy(scores, labels.expand(len(part), -1), reduction="sum")
        torch.autograd.grad(loss, part)

    def by_hand(part: Any, signals: Any) -> Any:
        return network.forward(part, signals, masks)

    mapped = torch.func.vmap(lambda w, x: network.forward(w[None], x[None], masks)[0])

    def one_after_another() -> None:
        for place in range(len(inputs)):
            slopes(weights[place : place + 1], inputs[place : place + 1], by_hand)

    ways = {
        "one after another": one_after_another,
        "vmap": lambda: slopes(weights, inputs, mapped),
        "batched by hand": lambda: slopes(weights, inputs, by_hand),
    }
    warnings.filterwarnings("ignore", message="There is a performance drop")  # vmap's, of what it lacks
    seconds: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(repeats + 1):  # in turn, so that all meet the same load; the first warms up
        for name, way in ways.items():
            seconds[name].append(timed(way)[1]["cpu_s"])
    best = {name: min(times[1:]) for name, times in seconds.items()}
    return {
        "places": len(inputs),
        "windows": inputs.shape[3],
        "weights": network.n_weights,
        "cpu_ms_a_place": {name: round(1000 * value / len(inputs), 2) for name, value in best.items()},
        "times_faster": round(best["one after another"] / best["batched by hand"], 2),
        "vmap_times_faster": round(best["one after another"] / best["vmap"], 2),
    }


def benchmark_training(windows: np.ndarray, classes: int, repeats: int = 3) -> dict[str, Any]:
    """Seconds by the clock of ten whole epochs of multi3net, the places in turn and together, by threads."""
    import torch

    labels = np.arange(len(windows)) % classes
    fold = np.arange(len(windows)) // classes % 5
    work = (windows[:, : Multi3Net().group], labels, fold, fold == 0)
    report: dict[str, Any] = {"windows": len(windows)}
    for threads in sorted({1, os.cpu_count() or 1}):
        torch.set_num_threads(threads)
        alone, together = (
            min(timed(partial(model.predict_folds, *work))[1]["wall_s"] for _ in range(repeats))
            for model in (Multi3Net(epochs=10, group=1), Multi3Net(epochs=10))
        )
        report[f"wall_s, {threads} threads"] = {"one after another": alone, "together": together}
        report[f"times_faster, {threads} threads"] = round(alone / together, 2)
    return report


def main() -> None:
    """Run what is asked for and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--sample", type=int, default=8, help="places for the forests")
    parser.add_argument("--only", default="networks,map")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    windows, rate, labels = make_library(options.results)
    report: dict[str, Any] = {}
    if "networks" in options.only:
        some = np.concatenate([part[:, : Multi3Net().group] for part in windows[:60]])
        report["networks"] = benchmark_networks(some, ACTIVITIES)
        report["training"] = benchmark_training(some, ACTIVITIES)
    if "map" in options.only:
        report["map"] = benchmark_map(windows, rate, labels, options.sample)
    for part, values in report.items():
        print(part)
        for name, value in values.items():
            print(f"  {name}: {value}")
    if options.json:
        write_json(options.json, report)


if __name__ == "__main__":
    main()
