# SPDX-License-Identifier: GPL-3.0-or-later
"""How recordings look: enough to draw them for whoever marks stretches."""

from pathlib import Path
from typing import Any

import numpy as np

from .formats import read_recording
from .recording import ImuRecording
from .recording_folder import LABEL_FILE, recording_files

PIECES = 400


def outlines(folder: Path) -> dict[str, Any]:
    """Each recording in a folder as plain values, and what cannot be read, with the reason."""
    shown, skipped = [], []
    for path in recording_files(folder, folder / LABEL_FILE):
        file = path.relative_to(folder).as_posix()
        try:
            shown.append({"file": file} | _outline(read_recording(path)))
        except (ValueError, OSError, KeyError) as error:
            skipped.append((file, str(error)))
    return {"recordings": shown, "skipped": skipped}


def _outline(recording: ImuRecording) -> dict[str, Any]:
    """Seconds of a recording, and least and most specific force of its first sensor in each piece, m/s2."""
    size = np.linalg.norm(recording.acc[:, 0].astype(float), axis=1)
    first = np.unique(np.arange(PIECES) * len(size) // PIECES)
    ends = np.stack([of.reduceat(size, first) for of in (np.fmin, np.fmax)], axis=1).round(2)
    known = [pair.tolist() if np.isfinite(pair).all() else None for pair in ends]
    return {"seconds": round(recording.n_samples / recording.rate, 2), "signal": known}
