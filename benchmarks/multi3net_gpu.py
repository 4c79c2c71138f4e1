# SPDX-License-Identifier: GPL-3.0-or-later
"""`multi3net` on a GPU: each training step a replayed CUDA graph, against the same steps launched one by one.

    python -m benchmarks.multi3net_gpu [--patches 512] [--windows 1500] [--epochs 80] [--compiled]

Made windows of 2 s at 50 Hz, 16 activities, five folds. Printed are the seconds of each way, transfers and
naming included, their ratio, the share of windows that both name alike and the accuracy of each. A few
patches are trained before, so that neither way pays for CUDA's start. With `--compiled` a third
way, `Multi3Net(compiled=True)`: its first run compiles, its second shows what a step then takes.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass

import numpy as np

from w2w_studies.classifiers.multi3net.classifier import Multi3Net

ACTIVITIES, FOLDS, SAMPLES = 16, 5, 100


@dataclass(frozen=True)
class Outcome:
    """Of five folds, by one way."""

    seconds: float
    named: np.ndarray  # (W, N): classes
    accuracy: float


def main() -> None:
    """Read the command line; exit with 1 where there is no GPU."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--patches", type=int, default=512)
    parser.add_argument("--windows", type=int, default=1500)
    parser.add_argument("--epochs", type=int, default=80)
    parser.add_argument("--compiled", action="store_true")
    choice = parser.parse_args()
    if why := no_gpu():
        sys.exit(why)
    graph, eager = both_ways(choice.patches, choice.windows, choice.epochs)
    ways = {"launched one by one": eager, "a replayed graph": graph}
    if choice.compiled:
        work = (Multi3Net(epochs=choice.epochs, compiled=True), *library(choice.patches, choice.windows))
        ways |= {name: trained(*work) for name in ("compiled, first", "compiled, again")}
    for name, one in ways.items():
        print(f"{name:20} {one.seconds:7.1f} s   ratio {one.seconds / eager.seconds:.2f}", end="")
        print(f"   alike {(one.named == eager.named).mean():.3f}   accuracy {one.accuracy:.3f}")


def no_gpu() -> str:
    """Why nothing can be measured here, as a sentence, or ""."""
    if problem := Multi3Net.unavailable():
        return problem
    import torch

    return "" if torch.cuda.is_available() else "PyTorch finds no GPU here: run this on a machine with one."


def both_ways(patches: int, windows: int, epochs: int) -> tuple[Outcome, Outcome]:
    """The five folds by graph and step by step."""
    work = library(patches, windows)
    trained(Multi3Net(epochs=1), *library(4, windows))
    graph, eager = (Multi3Net(epochs=epochs, replayed=replayed) for replayed in (True, False))
    return trained(graph, *work), trained(eager, *work)


def library(patches: int, windows: int) -> tuple[np.ndarray, np.ndarray]:
    """Windows (W, N, samples, 6) of swings, harder to tell from patch to patch; and their activities (W,)."""
    rng = np.random.default_rng(0)
    labels = np.arange(windows) % ACTIVITIES
    turns = (labels[:, None] + 1) * np.arange(SAMPLES) / SAMPLES
    swings = np.sin(2 * np.pi * (turns + rng.uniform(0, 1, (windows, 1)))).astype(np.float32)
    made = rng.standard_normal((windows, patches, SAMPLES, 6), dtype=np.float32)
    made *= np.geomspace(1, 20, patches, dtype=np.float32)[:, None, None]
    made += 3 * swings[:, None, :, None]
    return made, labels


def trained(settings: Multi3Net, made: np.ndarray, labels: np.ndarray) -> Outcome:
    """Five folds of made windows."""
    fold = np.arange(len(labels)) // ACTIVITIES % FOLDS
    start = time.perf_counter()
    named = settings.predict_folds(made, labels, fold, np.ones(len(labels), bool))
    seconds = time.perf_counter() - start
    return Outcome(seconds, named, float((named == labels[:, None]).mean()))


if __name__ == "__main__":
    main()
