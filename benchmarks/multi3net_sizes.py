# SPDX-License-Identifier: GPL-3.0-or-later
"""What multi3net loses by its size: the default and the published sizes on the paper's 11 placements.

    python -m benchmarks.multi3net_sizes RESULTS [--side left] [--epochs 300] [--work FOLDER]

RESULTS is the folder of a finished `w2w run`. Prints macro F1 of each placement, the mean, and the processor
seconds each size took. FOLDER keeps what is finished: the published size takes hours on two cores.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from blender_addon.w2w.core.classifiers.multi3net import Multi3Net
from blender_addon.w2w.core.placements import DEFAULT_SIDE, placement_patches
from headless.finished import FinishedStudy

from .classifier_agreement import rank_again


def main() -> None:
    """Rank the placements by both sizes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("--side", choices=("left", "right"), default=DEFAULT_SIDE)
    parser.add_argument("--epochs", type=int, default=Multi3Net.full().epochs, help="of the published size")
    parser.add_argument("--work", type=Path)
    options = parser.parse_args()
    study = FinishedStudy.load(options.results)
    places = placement_patches(study.body(), study.patches, options.side)
    sizes = {"default": Multi3Net(), "published": Multi3Net.full(epochs=options.epochs)}
    maps = {}
    for name, model in sizes.items():
        started = time.process_time()
        maps[name] = rank_again(study, model, list(places.values()), options.work)
        print(f"{name}: {time.process_time() - started:.0f} processor seconds", flush=True)
    print(f"{'':20}" + "".join(f"{name:>12}" for name in sizes))
    for row, place in enumerate((*places, "mean")):
        scores = [m.mean.mean() if place == "mean" else m.mean[row] for m in maps.values()]
        print(f"{place:20}" + "".join(f"{score:12.3f}" for score in scores))


if __name__ == "__main__":
    main()
