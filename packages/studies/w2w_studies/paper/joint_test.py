# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's joint test: what one classifier on a set's sensors reaches, in figures and in a sentence."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from w2w.core.files import DIGITS
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.selection.promise import Promise
from w2w.core.study.results import StudyResults
from w2w.core.windows.inputs import PatchBlocks, as_blocks

from .subsets import ROUNDING

AT_MOST = 6
"""Sensors that are tested together: the classifier's width grows with each."""

WORKERS = 2
"""Sets tested at the same time."""


def multi_sensor_check(
    order: Sequence[int],
    inputs: np.ndarray | PatchBlocks,
    protocol: CrossValidation,
    classifier: Any = Ridge.name,
    resamples: int = 500,
) -> list[UtilityMap]:
    """Test the mean of maxima: one classifier on the chosen sensors' signals together.

    `order`: patches as chosen.
    `inputs` (W, N, D): features or windows of all patches, as for `utility_map`.
    `protocol`: the same gives the same folds. `classifier`, `resamples`: as for `utility_map`.
    One map for the first sensor alone, the first two together, and so on; each of one patch, the sensors'
    inputs side by side along the last axis. Their clips are not halved: Gram matrices of so many features by
    every half would take much memory.
    """
    source = as_blocks(inputs)
    alone = [source.patches([patch])[:, 0] for patch in order]

    def first(size: int) -> UtilityMap:
        worn = np.stack(alone[:size], axis=-2)
        together = worn.reshape(*worn.shape[:-2], -1)[:, None]
        return utility_map(together, protocol, classifier, resamples=resamples, halvings=0)

    workers = WORKERS if classifier == Ridge.name else 1  # others use all processors by themselves
    with threadpool_limits(1 if workers > 1 else None), ThreadPoolExecutor(workers) as pool:
        return list(pool.map(first, range(len(order), 0, -1)))[::-1]  # what takes longest first


def sensors_together(study: StudyResults, order: Sequence[int]) -> list[UtilityMap]:
    """Test the first sensors of a study, up to `AT_MOST`, by the folds of the run and its classifier.

    Of a classifier that takes windows, that is a network of 6 channels a sensor.
    """
    config, labels = study.config(), study.labels()
    inputs = study.inputs(config.classifier)
    return multi_sensor_check(order[:AT_MOST], inputs, labels.protocol(config), config.classifier)


def together_content(together: Sequence[UtilityMap], made: Promise | None = None) -> list[dict[str, Any]]:
    """What one classifier on the first sensor, the first two, and so on would reach, and reached here."""
    content = []
    for number, tested in enumerate(together):
        expected = [] if made is None else [made.mean[number], made.low[number], made.high[number]]
        mean, *interval = [round(float(value), DIGITS) for value in expected] or [None]
        scores = (tested.mean[0], tested.mean_low[0], tested.mean_high[0])
        reached, *around = [round(float(value), DIGITS) for value in scores]
        content.append(
            {
                "sensors": number + 1,
                "classifier": tested.classifier,
                "expected_f1": mean,
                "expected_f1_interval": interval or None,
                "mean_f1": reached,
                "mean_f1_interval": around,
                "f1": dict(zip(tested.activities, tested.f1[0].round(DIGITS).tolist(), strict=True)),
            }
        )
    return content


def joint_content(
    together: Sequence[dict[str, Any]], target: float, chosen: int, least: int = 1
) -> dict[str, Any] | None:
    """The smallest set whose joint classifier reaches the target, else the one that comes nearest.

    `together`: what one classifier on the first sensor, the first two, and so on reached, and, where it is
    known, would reach on other clips.
    `chosen`: sensors of the whole set, of which only the first few are tested together.
    `least`: fewest sensors that do what the designer asked for.
    Returns None if nothing was tested together.
    """
    tested = [entry for entry in together if entry["sensors"] >= least] or list(together[-1:])
    if not tested:
        return None
    reaching = [entry for entry in tested if entry["mean_f1"] >= target - ROUNDING]
    best = reaching[0] if reaching else max(tested, key=lambda entry: entry["mean_f1"])
    return {
        "sensors": best["sensors"],
        "expected_f1": best.get("expected_f1"),
        "expected_f1_interval": best.get("expected_f1_interval"),
        "mean_f1": best["mean_f1"],
        "mean_f1_interval": best["mean_f1_interval"],
        "target": target,
        "reached": bool(reaching),
        "sentence": _sentence(best, tested[-1], target, chosen, bool(reaching)),
    }


def sensors(count: int) -> str:
    """So many sensors, in words."""
    return f"{count} sensor{'' if count == 1 else 's'}"


def _sentence(best: dict[str, Any], last: dict[str, Any], target: float, chosen: int, reached: bool) -> str:
    score = f"F1 {best['mean_f1']:.3f} with {sensors(best['sensors'])}"
    if best.get("expected_f1") is not None:
        low, high = best["expected_f1_interval"]
        expected = f"expected F1 {best['expected_f1']:.3f} on other clips"
        interval = f"95 % interval {low:.2f} to {high:.2f}"
        lead = f"{expected} with {sensors(best['sensors'])} ({interval}); on these clips, "
    else:
        lead = ""
    if reached:
        return f"{lead}tested together, one classifier reaches {score} (target {target:.3g})"
    text = (
        f"{lead}tested together, up to {sensors(last['sensors'])} do not reach {target:.3g}: {score} at best"
    )
    if last["mean_f1"] < best["mean_f1"] - ROUNDING:
        text += f", {last['mean_f1']:.3f} with {last['sensors']}"
    return text + (f"; more than {last['sensors']} were not tested" if chosen > last["sensors"] else "")
