# SPDX-License-Identifier: GPL-3.0-or-later
"""An editor and mypy find `w2w` in the environment of `make setup`: by plain paths, not by an import hook."""

import subprocess
import sys
from pathlib import Path

import pytest

PATHS = Path(
    sys.prefix, "lib", f"python3.{sys.version_info.minor}", "site-packages", "where_to_wear_paths.pth"
)


@pytest.mark.later
@pytest.mark.skipif(not PATHS.is_file(), reason="this environment was not made by this tree's make setup")
def test_mypy_finds_w2w_by_its_path(tmp_path):
    (tmp_path / "mine.py").write_text("import w2w\n\nreveal_type(w2w.example_motions())\n", encoding="utf-8")
    words = [sys.executable, "-m", "mypy", "--python-executable", sys.executable, "mine.py"]
    said = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert '"w2w.api.loading.Motions"' in said.stdout
