# SPDX-License-Identifier: GPL-3.0-or-later
"""Orientations in an OpenSim storage file, to check what W2W writes."""

from pathlib import Path

import numpy as np


def read_orientation_sto(path: Path) -> tuple[np.ndarray, float, tuple[str, ...]]:
    """Quaternions (T, N, 4) as w, x, y, z, samples per second, and sites."""
    lines = path.read_text().splitlines()
    start = lines.index("endheader")
    facts = dict(line.split("=", 1) for line in lines[:start] if "=" in line)
    assert facts["DataType"] == "Quaternion"
    sites = tuple(lines[start + 1].split("\t")[1:])
    rows = [[field.split(",") for field in line.split("\t")[1:]] for line in lines[start + 2 :]]
    return np.array(rows, dtype=np.float64), float(facts["DataRate"]), sites
