# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips that crash, hang or fill a worker, done inside the Blender program; run by `test_program.py`.

Arguments: a library, an empty folder for results, and the file for what was found.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "blender_addon"))
from w2w.headless.blender import find_libraries  # noqa: E402

find_libraries()
import numpy as np  # noqa: E402

from w2w.core.body.body import Body  # noqa: E402
from w2w.core.library.library import read_library  # noqa: E402
from w2w.core.study.clip_files import WORK  # noqa: E402
from w2w.core.study.config import StudyConfig  # noqa: E402
from w2w.core.study.signals import place_patches  # noqa: E402
from w2w.headless.runs.clip_task import ClipTask, Engine  # noqa: E402
from w2w.headless.runs.folder import make_folders  # noqa: E402
from w2w.headless.runs.workers import Crew, run_alone, run_tasks  # noqa: E402


@dataclass(frozen=True)
class BadTask(ClipTask):
    """A task whose file does something to a worker, but not to the program that hands it out."""

    kind: str = ""
    safe_process: int = 0

    def key(self, source_sha256):
        if self.kind == "crash" and os.getpid() != self.safe_process:
            os.kill(os.getpid(), signal.SIGSEGV)
        if self.kind == "hang" and os.getpid() != self.safe_process:
            time.sleep(600)
        return super().key(source_sha256)

    @property
    def features_file(self):
        if self.kind == "fill" and os.getpid() != self.safe_process:
            np.ones(self.engine.memory)  # eight times as many bytes
        return super().features_file


def main(library: str, out: str, report: str) -> None:
    """Do good and bad tasks together, and one call that dies."""
    folder, config = Path(out), StudyConfig(patches=8)
    make_folders(folder)
    body = Body.bundled()
    body.save(folder / WORK / "body.npz")
    place_patches(body, config).save(folder / WORK / "patches.npz")
    clips = [clip for clip in read_library(library).clips if "good" in clip.file]
    limits = {"crash": 300.0, "hang": 10.0, "fill": 300.0, "": 300.0}
    tasks = [
        BadTask(
            clip,
            folder,
            config,
            "inputs",
            Engine(limit_s=limit, memory=2 * 2**30),
            kind=kind,
            safe_process=os.getpid(),
        )
        for clip, (kind, limit) in zip(clips, limits.items(), strict=True)
    ]
    told = []
    with closing(Crew()) as crew:
        run_tasks(tasks, 2, "", told.append, crew)
    reasons = {record["clip"]: record["reason"] for record in told}
    found = {
        "reasons": [reasons[task.clip.name] for task in tasks],
        "told": len(told),
        "alone": [run_alone(os._exit, 1), run_alone(os.getppid) == os.getpid()],
        "markers": [path.name for path in (folder / WORK / "running").iterdir()],
    }
    Path(report).write_text(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[-3:])
