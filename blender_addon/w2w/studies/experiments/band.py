# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of worn sensors' signals lies below a band limit: the real gait trial, site by site.

    python -m w2w.studies.experiments.band [FOLDER] [--trial S02-Trial-Walk-1]

Share of the alternating power (Hann window, mean removed, three axes together) below each frequency.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ..datasets.gait import read_gait

DEFAULT_FOLDER = Path(__file__).resolve().parents[5] / "shared" / "data" / "imu" / "gait"
LIMITS_HZ = (5, 8, 10, 12, 15, 20)


def shares(values: np.ndarray, rate: float) -> np.ndarray:
    """Share of the power below each limit, shape (N, limits), of signals (T, N, 3)."""
    values = values - values.mean(axis=0, dtype=np.float64)
    windowed = values * np.hanning(len(values))[:, None, None]
    power = (np.abs(np.fft.rfft(windowed, axis=0)) ** 2).sum(axis=2)
    frequency = np.fft.rfftfreq(len(values), 1 / rate)
    below = [power[frequency < limit].sum(axis=0) for limit in LIMITS_HZ]
    return np.stack(below, axis=1) / power.sum(axis=0)[:, None]


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", nargs="?", type=Path, default=DEFAULT_FOLDER)
    parser.add_argument("--trial", default="S02-Trial-Walk-1")
    options = parser.parse_args()
    recording = read_gait(options.folder, options.trial).recording
    print("| site | " + " | ".join(f"acc < {limit} Hz" for limit in LIMITS_HZ) + " | ", end="")
    print(" | ".join(f"gyr < {limit} Hz" for limit in LIMITS_HZ) + " |")
    print("|" + "---|" * (1 + 2 * len(LIMITS_HZ)))
    table = np.concatenate(
        [shares(values, recording.rate) for values in (recording.acc, recording.gyr)], axis=1
    )
    for site, row in zip(recording.sites, table, strict=True):
        print(f"| {site} | " + " | ".join(f"{share:.2f}" for share in row) + " |")


if __name__ == "__main__":
    main()
