# SPDX-License-Identifier: GPL-3.0-or-later
"""The files for containers install what Blender's module opens, and say the same."""

import re
from pathlib import Path

from w2w.headless.system_libraries import LIBRARIES

ROOT = Path(__file__).resolve().parents[1]


def run_lines() -> list[str]:
    return re.findall(r"^RUN (.*)$", (ROOT / "Dockerfile").read_text(), re.MULTILINE)


def test_every_library_of_the_system_is_installed() -> None:
    assert set(LIBRARIES.values()) <= set(run_lines()[0].split())


def test_apptainer_does_what_docker_does() -> None:
    post = (ROOT / "Apptainer").read_text().partition("%post\n")[2].partition("\n\n")[0]
    assert [line.strip() for line in post.splitlines()] == run_lines()
