# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of clips and the summary of a run, of files that it cannot read."""

import json

from w2w.core.findings.summary import write_failure
from w2w.core.library.library import Library
from w2w.core.study.clip_files import is_used, read_clip_list


def test_kinds_that_are_not_read_are_in_the_list_and_do_not_count_as_clips(tmp_path):
    library = Library(tmp_path, (), "", (("a.fbx", "it is empty"),), unread=((".mot", 2), (".txt", 1)))
    write_failure(tmp_path, library, "nothing to rank", [])
    listed = list(read_clip_list(tmp_path))
    assert [(entry["file"], entry.get("files")) for entry in listed] == [
        ("a.fbx", None),
        ("*.mot", 2),
        ("*.txt", 1),
    ]
    assert not any(map(is_used, listed))
    assert listed[1]["skipped"].startswith("2 files of kinds that are not read: 2 .mot; mot and sto hold")
    assert listed[2]["skipped"] == "1 file of kinds that are not read: 1 .txt"
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["clips"] == {"found": 1, "used": 0, "skipped": 1}
