# SPDX-License-Identifier: GPL-3.0-or-later
"""Check the figures in README and docs against the commands that they come from, or measure them anew.

An HTML comment names a quick command before the passage that holds its lines, up to the next heading or
mark::

    <!-- check: w2w sensors bmi270 | grep noise -->

Lines of long measurements are written by this program, with date and commit (``make evidence``)::

    <!-- figures: evidence.sh truth -->

    | data set | regret |

    *Measured on 2026-11-28 at 5fd86031.*

Their commands take minutes to hours. They run in .cache/evidence, which is kept, and find data sets in
$DATA; without it they are not run. The commit is the last one of the product: figures of that commit are not
measured again, so a stopped ``make evidence`` carries on.
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
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / ".cache" / "evidence"
DATA = Path(os.environ.get("DATA", ROOT.parent / "shared" / "data"))
MARK = re.compile(r"<!--\s*(?P<kind>check|figures):\s*(?P<command>.*?)\s*-->", re.DOTALL)
END = re.compile(r"^#{1,6} |<!--\s*(?:check|figures):|^\*(?:Measured on|Not measured) ", re.MULTILINE)
STAMP = re.compile(r"\*(?:Measured on \S+ at (?P<commit>\w+)|Not measured at this version)\.\*")
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
    measured: bool
    commit: str  # that its figures were measured at; "" if they never were


def checks_in(document: Path) -> Iterator[Check]:
    """The checks of a document, from top to bottom."""
    text = document.read_text(encoding="utf-8")
    for found in MARK.finditer(text):
        end = END.search(text, found.end())
        stamp = STAMP.match(text, end.start()) if end else None
        passage = text[found.end() : end.start() if end else len(text)]
        line = text.count("\n", 0, found.start()) + 1
        commit = (stamp and stamp["commit"]) or ""
        yield Check(document, line, found["command"], passage, found["kind"] == "figures", commit)


def lines_of(check: Check) -> list[str]:
    """What the command prints, without empty lines and with single spaces.

    Raises ValueError if it fails, takes too long or prints nothing.
    """
    path = os.pathsep.join((str(ROOT / ".venv" / "bin"), str(ROOT / "tools"), os.environ.get("PATH", "")))
    env = {**os.environ, "PATH": path, "W2W_ROOT": str(ROOT), "DATA": str(DATA), "COLUMNS": "200"}
    KEPT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        try:
            done = subprocess.run(
                ["bash", "-c", f"set -o pipefail; {check.command}"],
                cwd=KEPT if check.measured else folder,
                env=env,
                capture_output=True,
                text=True,
                timeout=None if check.measured else LIMIT_S,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise ValueError(f"the command took more than {LIMIT_S:g} s") from None
    if done.returncode:
        raise ValueError(f"the command failed ({done.returncode}): {done.stderr.strip()[-300:]}")
    if not (lines := _lines(done.stdout)):
        raise ValueError("the command printed nothing")
    return lines


def problems_of(check: Check) -> list[str]:
    """What is wrong with a passage, in sentences; nothing where it is up to date."""
    try:
        printed = lines_of(check)
    except ValueError as error:
        return [str(error)]
    passage = _plain(check.passage)
    missing = [line for line in printed if line not in passage]
    left = [line for line in _lines(check.passage) if check.measured and line not in printed]
    return [
        *(f"the command prints what the passage does not say: {line}" for line in missing),
        *(f"the passage says what the command does not print: {line}" for line in left),
    ]


def write(check: Check, commit: str) -> None:
    """Write the figures of a command into its document, with date and commit.

    Raises ValueError if the command fails or prints nothing.
    """
    lines = "\n".join(lines_of(check))
    text = check.document.read_text(encoding="utf-8")  # now: hours may have gone by
    at = text.index(check.command) + len(check.command)
    start = text.index("-->", at) + len("-->")
    end = END.search(text, start)
    stamp = STAMP.match(text, end.start()) if end else None
    rest = text[stamp.end() if stamp else start :]
    measured = f"*Measured on {datetime.now(UTC):%Y-%m-%d} at {commit}.*"
    partial = check.document.with_suffix(".part")
    partial.write_text(f"{text[:start]}\n\n{lines}\n\n{measured}{rest}", encoding="utf-8")
    partial.replace(check.document)


def commit_of_product() -> str:
    """The last commit that changed the product."""
    parts = ("blender_addon", "packages", "assets")
    command = ["git", "log", "-1", "--format=%h", "--abbrev=8", "--", *parts]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def _lines(text: str) -> list[str]:
    return [_plain(line) for line in text.splitlines() if line.strip()]


def _short(command: str) -> str:
    line = _plain(command)
    return line if len(line) <= SHOWN else f"{line[:SHOWN]}..."


def _plain(text: str) -> str:
    """The text with single spaces, and none around the bars of a table."""
    return re.sub(r" ?\| ?", "|", " ".join(text.split()))


def documents() -> list[Path]:
    """README and the documents."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def main(arguments: Sequence[str] | None = None) -> int:
    """Check documents, or write their figures; 1 where one is stale."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("documents", nargs="*", type=Path, help="[default: README.md and all in docs]")
    parser.add_argument("--quick", action="store_true", help="leave out the figures that take long")
    parser.add_argument("--write", action="store_true", help="measure and write figures of earlier commits")
    parser.add_argument("--list", action="store_true", help="list the commands and run none")
    asked = parser.parse_args(arguments)
    stale = ran = 0
    commit = commit_of_product() if asked.write else ""
    for check in [check for path in asked.documents or documents() for check in checks_in(path)]:
        where, command = f"{check.document.name}:{check.line}", _short(check.command)
        if asked.list or (check.measured and (asked.quick or not DATA.is_dir())):
            print(f"{where}: {'' if asked.list else 'not run: '}{command}")
            continue
        if asked.write and (not check.measured or check.commit == commit):
            continue
        try:
            found = write(check, commit) or [] if asked.write else problems_of(check)
        except ValueError as error:
            found = [str(error)]
        ran, stale = ran + 1, stale + bool(found)
        said = "stale" if found else "written" if asked.write else "up to date"
        print("\n  ".join([f"{where}: {said}: {command}", *found]), flush=True)
    print(f"{ran} {'written' if asked.write else 'checked'}, {stale} stale")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
