# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the quick commands that numbers in README and docs come from, and say which numbers are stale.

In a document an HTML comment names the command, before the passage that holds its numbers::

    <!-- check: w2w sensors bmi270 | grep noise -->

Every line that the command prints must be in that passage, up to the next heading or comment of the
kind; runs of spaces count as one. ``<!-- check-slow: ... -->`` is for commands of minutes and longer: they
are listed by ``--list``, and run by ``--slow`` only.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MARK = re.compile(r"<!--\s*check(?P<slow>-slow)?:\s*(?P<command>.*?)\s*-->", re.DOTALL)
END = re.compile(r"^#{1,6} |<!--\s*check(?:-slow)?:", re.MULTILINE)
LIMIT_S = 120.0
"""Seconds a quick command may take."""

SHOWN = 120
"""Letters of a command that are printed."""


@dataclass(frozen=True)
class Check:
    """A command, and the passage that must hold its lines."""

    document: Path
    line: int
    command: str
    passage: str
    slow: bool


def checks_in(document: Path) -> Iterator[Check]:
    """The checks of a document, from top to bottom."""
    text = document.read_text(encoding="utf-8")
    for found in MARK.finditer(text):
        end = END.search(text, found.end())
        passage = text[found.end() : end.start() if end else len(text)]
        line = text.count("\n", 0, found.start()) + 1
        yield Check(document, line, found["command"], passage, bool(found["slow"]))


def problems_of(check: Check, limit_s: float | None = LIMIT_S) -> list[str]:
    """What is wrong with a passage, in sentences; nothing where it is up to date."""
    path = os.pathsep.join((str(ROOT / ".venv" / "bin"), os.environ.get("PATH", "")))
    env = {**os.environ, "PATH": path, "W2W_ROOT": str(ROOT), "COLUMNS": "200"}
    with tempfile.TemporaryDirectory() as folder:
        try:
            done = subprocess.run(
                ["bash", "-c", f"set -o pipefail; {check.command}"],
                cwd=folder, env=env, capture_output=True, text=True, timeout=limit_s, check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return [f"the command took more than {limit_s:g} s: mark it check-slow"]
    if done.returncode:
        return [f"the command failed ({done.returncode}): {done.stderr.strip()[-300:]}"]
    lines = [_plain(line) for line in done.stdout.splitlines() if line.strip()]
    if not lines:
        return ["the command printed nothing"]
    passage = _plain(check.passage)
    return [
        f"the command prints what the passage does not say: {line}" for line in lines if line not in passage
    ]


def _short(command: str) -> str:
    line = _plain(command)
    return line if len(line) <= SHOWN else f"{line[:SHOWN]}..."


def _plain(text: str) -> str:
    return " ".join(text.split())


def documents() -> list[Path]:
    """README and the documents."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def main(arguments: Sequence[str] | None = None) -> int:
    """Check documents; 1 where one is stale."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("documents", nargs="*", type=Path, help="[default: README.md and all in docs]")
    parser.add_argument("--slow", action="store_true", help="run the slow commands, too")
    parser.add_argument("--list", action="store_true", help="list the commands and run none")
    asked = parser.parse_args(arguments)
    stale = ran = 0
    for check in (check for path in asked.documents or documents() for check in checks_in(path)):
        where, command = f"{check.document.name}:{check.line}", _short(check.command)
        if asked.list or (check.slow and not asked.slow):
            print(f"{where}: {'slow, not run: ' * check.slow}{command}")
            continue
        found = problems_of(check, None if check.slow else LIMIT_S)
        ran, stale = ran + 1, stale + bool(found)
        print(f"{where}: {'stale' if found else 'up to date'}: {command}")
        for problem in found:
            print(f"  {problem}")
    print(f"{ran} checked, {stale} stale")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
