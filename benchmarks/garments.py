# SPDX-License-Identifier: GPL-3.0-or-later
"""What cloth does to the signals: a run on the skin against runs of the same clips in a garment.

    python -m benchmarks.garments SKIN CLOTH...

The folders are of `w2w run` with the same clips and patches, all but the first with --garment. A
folder whose run has not come to its end is compared by the clips whose signals are there.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from w2w.core.body.body import Body
from w2w.core.clip_files import FITTED, WORK
from w2w.core.imu.recording import ImuRecording
from w2w.core.patches.garment_cover import load_covers
from w2w.core.patches.naming import resolve
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.utility import UtilityMap
from w2w.core.results_folder import UTILITY

PLACES = ("sternum", "upper spine", "left upper arm lateral", "left thigh front", "left shin")

GRAVITY = 9.80665


def differences(skin: Path, cloth: Path) -> dict[str, np.ndarray]:
    """RMS by clip and patch, shape (C, N): of what differs, of its size alone, and of the skin's motion."""
    parts = ("acc", "gyr", "size", "skin acc", "skin gyr")
    found: dict[str, list[np.ndarray]] = {name: [] for name in parts}
    for path in sorted((cloth / "signals").glob("[!.]*.npz")):
        here, there = ImuRecording.load(path), ImuRecording.load(skin / "signals" / path.name)
        sizes = [np.linalg.norm(side.acc, axis=2) for side in (here, there)]
        found["acc"].append(_rms(here.acc - there.acc))
        found["gyr"].append(_rms(here.gyr - there.gyr))
        found["size"].append(_rms((sizes[0] - sizes[1])[..., None]))
        found["skin acc"].append(_rms((sizes[1] - GRAVITY)[..., None]))
        found["skin gyr"].append(_rms(there.gyr))
    return {name: np.array(values) for name, values in found.items()}


def show_differences(skin: Path, cloth: Path) -> np.ndarray:
    """Print the differences of a garment's patches, and at the named places; gives the patches."""
    patches, body = PatchSet.load(cloth / WORK / "patches.npz"), Body.load(cloth / WORK / "body.npz")
    covers = load_covers(cloth / FITTED)
    covered = np.concatenate([own.patches for own in covers.values()])
    rms = differences(skin, cloth)
    clips = len(rms["acc"])
    print(f"{cloth.name}: {', '.join(covers)}, {len(covered)} of {len(patches)} patches, {clips} clips")
    print("place                     acc   |acc|  skin |acc|-g     gyr   skin gyr   (m/s2, rad/s; RMS)")
    places = {name: resolve(name, body, patches) for name in PLACES}
    rows = {name: np.array([patch]) for name, patch in places.items() if patch in covered}
    for name, chosen in ({"all covered, median": covered} | rows).items():
        values = [np.median(_over_clips(rms[part][:, chosen])) for part in rms]
        acc, gyr, size, own_acc, own_gyr = values
        print(f"{name:24}{acc:6.2f}{size:8.2f}{own_acc:14.2f}{gyr:8.2f}{own_gyr:11.2f}")
    bare = np.setdiff1d(np.arange(len(patches)), covered)
    print(f"largest difference of a patch on the skin: {rms['acc'][:, bare].max():.2g} m/s2")
    return covered


def show_ranking(skin: Path, cloth: Path, covered: np.ndarray) -> None:
    """Print what F1 and the map lose or gain over the covered patches."""
    if not (cloth / UTILITY).exists():
        print("its run has not come to its end: no ranking")
        return
    maps = [UtilityMap.load(folder / UTILITY) for folder in (skin, cloth)]
    before, after = (own.mean[covered] for own in maps)
    expected = [own.expected_mean[covered] for own in maps]
    print(f"F1 on these clips, mean over covered patches: skin {before.mean():.3f}, cloth {after.mean():.3f}")
    change = after - before
    print(f"change by patch: median {np.median(change):+.3f}, {change.min():+.3f} to {change.max():+.3f}")
    print(f"rho of the maps: F1 {spearmanr(before, after)[0]:.2f}, expected {spearmanr(*expected)[0]:.2f}")


def _rms(values: np.ndarray) -> np.ndarray:
    """Of vectors (T, N, 3 or 1) by patch."""
    return np.sqrt((values.astype(np.float64) ** 2).sum(axis=2).mean(axis=0))


def _over_clips(rms: np.ndarray) -> np.ndarray:
    return np.sqrt((rms**2).mean(axis=0))


def main() -> None:
    """Compare the folders given."""
    skin, *garments = (Path(argument) for argument in sys.argv[1:])
    for cloth in garments:
        covered = show_differences(skin, cloth)
        show_ranking(skin, cloth, covered)


if __name__ == "__main__":
    main()
