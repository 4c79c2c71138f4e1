# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a folder's results are those that a run would write: then it need not rank again."""

import hashlib
import json
from pathlib import Path

from w2w.core.clip_files import WORK
from w2w.core.files import file_sha256, write_json
from w2w.core.findings.summary import versions

from .folder import code_sha256
from .own_files import LIST, is_whole
from .study import Made, RunPlan

CURRENT = f"{WORK}/current.json"
"""What the results in the folder were made of, and the list of them."""


def note_current(plan: RunPlan, made: Made, out: Path) -> None:
    """Note what the results in a folder, which are all there now, were made of."""
    write_json(out / CURRENT, _content(plan, made, out))


def is_current(plan: RunPlan, made: Made, out: Path) -> bool:
    """Whether the results are all there, unchanged, and would come out the same."""
    try:
        before = json.loads((out / CURRENT).read_text(encoding="utf-8"))
        return before == _content(plan, made, out) and is_whole(out)
    except (OSError, ValueError, RecursionError):
        return False


def _content(plan: RunPlan, made: Made, out: Path) -> dict[str, str]:
    digest, library = hashlib.sha256(), plan.library
    study = plan.config.as_dict(), versions(), code_sha256(), plan.pictures, plan.report, plan.more
    body = [file_sha256(out / WORK / name) for name in ("body.npz", "patches.npz")]
    parts = [study, body, library.labelled_by, library.skipped, library.check]
    for part in parts:
        digest.update(repr(part).encode("utf-8", "backslashreplace"))
    for one in made.clips:
        clip = one.clip
        labels = clip.file, clip.name, clip.activity, clip.subject, clip.motion_key, clip.source
        digest.update(repr((*labels, one.reason, one.source_sha256)).encode())
    return {"made_of": digest.hexdigest(), "written": file_sha256(out / LIST)}
