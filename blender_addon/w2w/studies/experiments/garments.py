# SPDX-License-Identifier: GPL-3.0-or-later
"""What cloth does to the signals: a run on the skin against runs of the same clips in a garment.

    python -m w2w.studies.experiments.garments SKIN CLOTH...

The folders are of `w2w run` with the same clips and patches, all but the first with --garment. A
folder whose run has not come to its end is compared by the clips whose signals are there. Where
clips name two performers or more, 95 % intervals come from drawing performers, then clips of each.

At waist, thigh and lower leg it also says how the angle to the vertical goes with the skin's, as Jayasinghe,
Hwang and Harwin measured it on worn trousers (Sensors 2022, doi:10.3390/s22176605).
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from w2w.core.body.body import Body
from w2w.core.garments.cover import FITTED, load_covers
from w2w.core.imu.recording import ImuRecording
from w2w.core.patches.naming import resolve
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.agreement import spearman_rows
from w2w.core.ranking.f1 import ClipCounts, ClipUnits
from w2w.core.ranking.utility import UtilityMap
from w2w.core.study.clip_files import WORK
from w2w.core.study.results import UTILITY

from .garment_intervals import (
    RESAMPLES,
    between_halves,
    halves,
    interval,
    mean_f1,
    median_rms,
    performers_and_clips,
)

PLACES = ("sternum", "upper spine", "left upper arm lateral", "left thigh front", "left shin")

TILTED = {"waist": "hip", "thigh": "thigh lateral", "lower leg": "lower leg lateral"}
"""Patches beside the places of sensors on worn trousers."""

GRAVITY = 9.80665
SETTLING_S = 2.0
"""How fast the vertical that the gyroscope carries on follows the accelerometer."""


@dataclass(frozen=True, eq=False)
class Compared:
    """Clips of which there are signals on the skin and on cloth."""

    names: np.ndarray  # str (C,)
    performer: np.ndarray  # str (C,)
    activity: np.ndarray  # str (C,)
    rms: dict[str, np.ndarray]
    """(C, N): by clip and patch: of what differs, of its size alone, and of the skin's motion."""

    @cached_property
    def drawn(self) -> np.ndarray | None:
        """How often each clip is drawn, (B, C); None where all are of one performer."""
        if len(np.unique(self.performer)) < 2:
            return None
        return performers_and_clips(self.performer, self.activity, RESAMPLES, np.random.default_rng(0))


def compared(skin: Path, cloth: Path) -> Compared:
    """What differs in the clips whose signals are in both folders."""
    parts = ("acc", "gyr", "size", "skin acc", "skin gyr")
    found: dict[str, list[np.ndarray]] = {name: [] for name in parts}
    clips = []
    for path in sorted((cloth / "signals").glob("[!.]*.npz")):
        if not (skin / "signals" / path.name).exists():
            continue
        here, there = ImuRecording.load(path), ImuRecording.load(skin / "signals" / path.name)
        sizes = [np.linalg.norm(side.acc, axis=2) for side in (here, there)]
        found["acc"].append(_rms(here.acc - there.acc))
        found["gyr"].append(_rms(here.gyr - there.gyr))
        found["size"].append(_rms((sizes[0] - sizes[1])[..., None]))
        found["skin acc"].append(_rms((sizes[1] - GRAVITY)[..., None]))
        found["skin gyr"].append(_rms(there.gyr))
        clips.append((here.clip, here.subject, here.activity))
    if not clips:
        raise SystemExit("no clip has signals in both folders")
    names, performer, activity = (np.array(column) for column in zip(*clips, strict=True))
    return Compared(names, performer, activity, {name: np.array(values) for name, values in found.items()})


def show_differences(cloth: Path, clips: Compared) -> np.ndarray:
    """Print the differences of a garment's patches, and at the named places; gives the patches."""
    patches, body = PatchSet.load(cloth / WORK / "patches.npz"), Body.load(cloth / WORK / "body.npz")
    covers = load_covers(cloth / FITTED)
    covered = np.concatenate([own.patches for own in covers.values()])
    rms, count = clips.rms, len(clips.names)
    print(f"{cloth.name}: {', '.join(covers)}, {len(covered)} of {len(patches)} patches, {count} clips")
    print("place                     acc   |acc|  skin |acc|-g     gyr   skin gyr   (m/s2, rad/s; RMS)")
    places = {name: resolve(name, body, patches) for name in PLACES}
    rows = {name: np.array([patch]) for name, patch in places.items() if patch in covered}
    for name, chosen in ({"all covered, median": covered} | rows).items():
        values = [median_rms(rms[part][:, chosen], np.ones((1, count)))[0] for part in rms]
        acc, gyr, size, own_acc, own_gyr = values
        print(f"{name:24}{acc:6.2f}{size:8.2f}{own_acc:14.2f}{gyr:8.2f}{own_gyr:11.2f}")
    if (drawn := clips.drawn) is not None:
        shown = {"acc": "acc", "|acc|": "size", "gyr": "gyr"}
        spans = {name: interval(median_rms(rms[part][:, covered], drawn)) for name, part in shown.items()}
        print("median, 95 %: " + ", ".join(f"{name} {_span(span)}" for name, span in spans.items()))
    bare = np.setdiff1d(np.arange(len(patches)), covered)
    print(f"largest difference of a patch on the skin: {rms['acc'][:, bare].max():.2g} m/s2")
    return covered


def show_ranking(skin: Path, cloth: Path, clips: Compared, covered: np.ndarray) -> None:
    """Print what F1 and the map lose or gain over the covered patches."""
    if not (cloth / UTILITY).exists():
        print("its run has not come to its end: no ranking")
        return
    maps = [UtilityMap.load(folder / UTILITY) for folder in (skin, cloth)]
    before, after = (own.mean[covered] for own in maps)
    expected = [own.expected_mean[covered] for own in maps]
    print(f"{maps[1].protocol}; F1 on these clips, mean over covered patches:")
    print(f"skin {before.mean():.3f}, cloth {after.mean():.3f}")
    change = after - before
    print(f"change by patch: median {np.median(change):+.3f}, {change.min():+.3f} to {change.max():+.3f}")
    print(f"rho of the maps: F1 {spearman_rows(before, after):.2f}, expected {spearman_rows(*expected):.2f}")
    if (drawn := clips.drawn) is None:
        return
    counts = [_counted(own, clips, covered) for own in maps]
    f1 = [mean_f1(own, drawn) for own in counts]
    means = [own.mean(axis=1) for own in f1]
    spans = {"skin": means[0], "cloth": means[1], "difference": means[1] - means[0]}
    spans["rho"] = spearman_rows(*f1)
    print("95 %: " + ", ".join(f"{name} {_span(interval(own), 3)}" for name, own in spans.items()))
    rho = between_halves(*counts, halves(clips.performer))
    print("rho by other performers: " + ", ".join(f"{name} {value:.2f}" for name, value in rho.items()))


def show_tilts(skin: Path, cloth: Path, covered: np.ndarray) -> None:
    """Print r between the angles to the vertical on skin and on cloth, the median over patches, by clip."""
    names = PatchSet.load(cloth / WORK / "patches.npz").names
    print(f"r of the angle to the vertical: {', '.join(TILTED)}")
    for path in sorted((cloth / "signals").glob("[!.]*.npz")):
        if not (skin / "signals" / path.name).exists():
            continue
        sides = [ImuRecording.load(folder / "signals" / path.name) for folder in (skin, cloth)]
        found = []
        for words in TILTED.values():
            patches = [patch for patch in covered.tolist() if words in names[patch]]
            angles = [tilts(side.at(patches)) for side in sides]
            r = [abs(np.corrcoef(a, b)[0, 1]) for a, b in zip(*angles, strict=True)]
            found.append(f"{np.median(r):.2f}" if r else "none covered")
        print(f"  {path.stem}: {', '.join(found)}")


def tilts(recording: ImuRecording) -> np.ndarray:
    """How far each sensor leans in the plane in which it leans most, about its mean, shape (N, T), rad.

    A complementary filter: the gyroscope carries the vertical on, the accelerometer corrects it.
    """
    force, spin = recording.acc.astype(np.float64), recording.gyr.astype(np.float64)
    felt = force / np.linalg.norm(force, axis=2, keepdims=True)
    step = 1 / recording.rate
    up, found = felt[: round(recording.rate / 2)].mean(axis=0), np.empty_like(felt)
    for _ in range(2):  # the first pass finds where the second starts
        for number, (seen, turning) in enumerate(zip(felt, spin, strict=True)):
            up = up - np.cross(turning, up) * step + (seen - up) * step / SETTLING_S
            up /= np.linalg.norm(up, axis=1, keepdims=True)
            found[number] = up
    centred = (found - found.mean(axis=0)).transpose(1, 0, 2)
    plane, sizes, _ = np.linalg.svd(centred, full_matrices=False)
    return plane[:, :, 0] * sizes[:, :1]


def _counted(own: UtilityMap, clips: Compared, covered: np.ndarray) -> ClipCounts:
    """Counts of the clips in the order of the signals."""
    tested = np.unique(own.clip)
    if not np.array_equal(tested, clips.names[np.argsort(clips.names)]):
        raise SystemExit("the two runs did not test the same clips, or some hold the same motion")
    place = np.argsort(np.argsort(clips.names))
    counts = ClipUnits(own.truth, own.clip, len(own.activities)).count(own.predictions[:, covered])
    return ClipCounts(*(getattr(counts, name)[place] for name in ("hit", "named", "size", "activity")))


def _span(span: tuple[float, float], digits: int = 2) -> str:
    return f"{span[0]:.{digits}f} to {span[1]:.{digits}f}"


def _rms(values: np.ndarray) -> np.ndarray:
    """Of vectors (T, N, 3 or 1) by patch."""
    return np.sqrt((values.astype(np.float64) ** 2).sum(axis=2).mean(axis=0))


def main() -> None:
    """Compare the folders given."""
    skin, *garments = (Path(argument) for argument in sys.argv[1:])
    for cloth in garments:
        clips = compared(skin, cloth)
        covered = show_differences(cloth, clips)
        show_tilts(skin, cloth, covered)
        show_ranking(skin, cloth, clips, covered)


if __name__ == "__main__":
    main()
