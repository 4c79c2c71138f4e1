# SPDX-License-Identifier: GPL-3.0-or-later
"""How many threads numerical work may use in this process."""

from __future__ import annotations

import os


def n_threads() -> int:
    """As many as ``OMP_NUM_THREADS`` allows (process pools set it), else one a usable core."""
    allowed = os.environ.get("OMP_NUM_THREADS", "")
    if allowed.isdigit() and int(allowed) > 0:
        return int(allowed)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
