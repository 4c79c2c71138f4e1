# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be tried of Windows and macOS here: no module that only Unix has, deep folders, names alike."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ONLY_UNIX = ("fcntl", "grp", "pwd", "resource", "termios", "tty")

RUN = f"""
import sys
sys.modules.update(dict.fromkeys({ONLY_UNIX}))
from w2w.headless.start import main
sys.exit(main())
"""

DEEP = Path(*["a folder with a long name, as people give them to their projects"] * 5)
"""Longer than the 260 characters that Windows allows by default."""


@pytest.mark.slow
def test_a_run_needs_nothing_that_only_unix_has(motions: Path, tmp_path: Path) -> None:
    out = tmp_path / DEEP / "out"
    options = ("--patches", "8", "--no-pictures", "--no-report", "--workers", "1", "--folds", "2")
    command = [sys.executable, "-c", RUN, "run", str(motions), "--out", str(out), *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(str(out)) > 260
    assert json.loads((out / "summary.json").read_text(encoding="utf-8"))["clips"]["used"] == 8
    # nor do two files differ by case alone
    names = [path.relative_to(out).as_posix().lower() for path in out.rglob("*")]
    assert len(set(names)) == len(names) > 20
