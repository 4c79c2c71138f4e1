# SPDX-License-Identifier: GPL-3.0-or-later
"""What each stage of a run makes of a small library, as a few numbers that any processor gives.

`python -m tests.golden` writes `golden.json` anew; it refuses where a stage gives others than its version
did.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from w2w.core.body.body import Body
from w2w.core.imu.presets import DEFAULT_SENSOR, preset
from w2w.core.study.ranking import RANKING_VERSION
from w2w.core.study.signals import SIGNALS_VERSION

from .command_line import cli
from .core.readers.test_bvh import write_bvh
from .exercises import exercises
from .here import clips_here, ranked_roughly

GOLDEN = Path(__file__).with_suffix(".json")

VERSIONS = {"signals": [SIGNALS_VERSION], "ranking": [SIGNALS_VERSION, RANKING_VERSION]}
"""Versions that each stage depends on."""

TOLERANCE = {"motion": 1e-6, "signals": 0.25, "features": 3e-3, "ranking": 1e-2, "chosen": 0}
"""How far digests may differ, in their own unit, at least five times what they do on other processors."""

CLIPS = 4
"""Clips an activity; of one of them a BVH file is read."""

OPTIONS = "--patches 12 --workers 1 --no-pictures --no-report --max 2 --target 1"
TRIADS = {"acc": "accelerometer", "gyr": "gyroscope"}
RANKED = ("f1", "f1_low", "expected_f1", "expected_low", "mean_high", "trial_f1")

WAVES = np.sqrt((2, 3, 5, 7))
"""Turns a value of the waves that arrays are held against."""

Digests = dict[str, dict[str, list[float]]]


def outcome(folder: Path) -> Digests:
    """What a run in an empty folder makes, by stage; signals in the steps of the sensor, features as logs."""
    out = folder / "results"
    _write_library(folder / "library")
    with clips_here(), ranked_roughly():
        code, said = cli("run", folder / "library", "--out", out, *OPTIONS.split())
    if code:
        raise RuntimeError(said)
    motions, signals, features, utility = (
        _columns(sorted(out.glob(files)))
        for files in ("motions/*.npz", "signals/*.npz", ".w2w/features/*.npz", "utility.npz")
    )
    sensor, summary = preset(DEFAULT_SENSOR), json.loads((out / "summary.json").read_text("utf-8"))
    worn = summary["worn_together"]
    chosen = [summary["answer"]["patch"], *(place["patch"] for place in worn["places"])]
    made = {f"motion {name}": digest(motions[name]) for name in ("poses", "trans")}
    for name, triad in TRIADS.items():
        made[f"signals {name}"] = digest(signals[name] / getattr(sensor, triad).resolution)
    made["features"] = digest(np.log1p(np.abs(features["features"])))
    ranked = {f"ranking {name}": digest(utility[name]) for name in RANKED}
    ranked["ranking set"] = [worn["expected_f1"], *worn["f1"].values()]
    return {"signals": made, "ranking": ranked | {"chosen": chosen}}


def digest(array: np.ndarray) -> list[float]:
    """Amplitudes of an array along some waves; noise of one in its values is about one in these, too."""
    flat = np.nan_to_num(array.astype(float)).ravel()
    amplitudes = np.cos(WAVES[:, None] * np.arange(len(flat))) @ flat * np.sqrt(2 / len(flat))
    return [round(float(each), 8) for each in amplitudes]


def complaint(stage: str, found: dict[str, list[float]], known: dict[str, Any]) -> str:
    """What to do about a stage's digests if they are not those `known` of its version; "" if they are."""
    before = known[stage]["digests"]
    others = [
        name
        for name, values in found.items()
        if name not in before
        or not np.allclose(values, before[name], rtol=0, atol=TOLERANCE[name.split()[0]])
    ]
    if known[stage]["version"] != VERSIONS[stage]:
        return f"the version of {stage} was raised: write tests/golden.json by python -m tests.golden"
    return bool(others) * (
        f"{stage} differ from what this version made ({', '.join(others)}). If that is meant, raise "
        f"{stage.upper()}_VERSION in core/study/{stage}.py, so that runs make theirs anew, and write "
        "tests/golden.json by python -m tests.golden"
    )


def _write_library(folder: Path) -> None:
    body = Body.bundled()
    for number, (file, motion) in enumerate(exercises(CLIPS).items()):
        path = folder / motion.activity / Path(file).name
        path.parent.mkdir(parents=True, exist_ok=True)
        if number % CLIPS:
            motion.save(path)
        else:
            write_bvh(path.with_suffix(".bvh"), body, motion)


def _columns(files: Iterable[Path]) -> dict[str, np.ndarray]:
    """Arrays by their names, those of all files one after another."""
    parts: dict[str, list[np.ndarray]] = {}
    for file in files:
        with np.load(file, allow_pickle=False) as stored:
            for name, array in stored.items():
                parts.setdefault(name, []).append(array.ravel())
    return {name: np.concatenate(arrays) for name, arrays in parts.items()}


def main() -> None:
    """Write the digests of all stages, unless one differs whose version was not raised."""
    with TemporaryDirectory() as folder:
        made = outcome(Path(folder))
    known = json.loads(GOLDEN.read_text("utf-8")) if GOLDEN.exists() else {}
    for stage in [stage for stage in known if known[stage]["version"] == VERSIONS[stage]]:
        if why := complaint(stage, made[stage], known):
            raise SystemExit(why)
    stages = {stage: {"version": VERSIONS[stage], "digests": found} for stage, found in made.items()}
    GOLDEN.write_text(json.dumps(stages, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
