# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator's page: who uses the server, how much of it, and what is at work."""

import shutil
from collections.abc import Mapping
from contextlib import suppress
from html import escape

from .guard import PAGES, Doors
from .people import OPERATOR, folder_of_person
from .receiving import IN_ALL, OF_ONE, folder_size
from .study import Study
from .uploads import RefusedError
from .work import DAY_S, Work

MEGABYTE = 1e6


def operates(doors: Doors, owner: str) -> bool:
    """Whether an owner runs the server: whoever is on this machine, else the person `operator`."""
    return not doors.asks or owner == folder_of_person(OPERATOR)


def operator_page(work: Work, doors: Doors, uploads: Mapping[str, int]) -> str:
    """The page, with a row for each person; `uploads` that arrive now by their folders."""
    names = {folder_of_person(name): name for name in doors.people.hashes()} | {"local": "this machine"}
    rows, total = [], 0
    came = {folder for name in names if (folder := work.data / name).is_dir()}
    for folder in sorted({study.folder.parent for study in work.studies()} | came):
        studies = [study for study in work.studies() if study.folder.parent == folder]
        size = folder_size(folder)
        running = sum(study.id in work.running for study in studies)
        waiting = sum(_waits(work, study) for study in studies) - running
        idle = min((max(0.0, study.idle_s()) for study in studies), default=0.0) / DAY_S
        megabytes, arriving = f"{size / MEGABYTE:.0f}", uploads.get(folder.name, 0)
        cells = [len(studies), megabytes, arriving, running, waiting, f"{idle:.0f}"]
        numbers = "".join(f'<td class="n">{cell}</td>' for cell in cells)
        rows.append(f'<tr><th scope="row">{escape(names.get(folder.name, "a token"))}</th>{numbers}</tr>')
        total += size
    most, free = doors.most / MEGABYTE, shutil.disk_usage(work.data).free / MEGABYTE
    used = f"{total / MEGABYTE:.0f} of {IN_ALL * most:.0f} MB are used"
    sentence = f"{used}; one person may use {OF_ONE * most:.0f} MB. The disk has {free:.0f} MB left."
    text = (PAGES / "operator.html").read_text(encoding="utf-8")
    return text.replace("{{ sentence }}", sentence).replace("{{ rows }}", "\n".join(rows))


def _waits(work: Work, study: Study) -> bool:
    with suppress(RefusedError):
        return work.waits(study)
    return False
