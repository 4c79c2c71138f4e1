# SPDX-License-Identifier: GPL-3.0-or-later
"""What a results folder's list says of clips."""

from pathlib import Path
from typing import Any

from w2w.core.study.clip_files import is_used, read_clip_list


def used_clips(out: Path) -> list[dict[str, Any]]:
    """Those that were turned into signals."""
    return [entry for entry in read_clip_list(out) if is_used(entry)]


def skipped_clips(out: Path) -> dict[str, str]:
    """Reason by file, of the others."""
    return {entry["file"]: entry["skipped"] for entry in read_clip_list(out) if not is_used(entry)}
