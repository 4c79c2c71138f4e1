# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w run` by this version and by another, one after the other: what each step takes of the other's time.

    python -m benchmarks.versions LIBRARY OTHER [--rounds 5] [--options "--patches 64"]

OTHER is the other version's program, such as `../before/.venv/bin/w2w`. Each round runs both from nothing
and then once more, when there is nothing to do. Printed are medians by the clock and of the processor, and
ratios. Both keep what Python compiles, as it does by itself: the environment may say otherwise.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

STEP = re.compile(r"^([A-Z][^:\n]*): ([0-9.]+) s *$", re.MULTILINE)

WHOLE, PROCESSOR, AGAIN = "the whole", "processor", "the same command once more"


def seconds(program: str, library: Path, out: Path, options: list[str]) -> dict[str, float]:
    """Seconds of the steps of a run, of the whole, and of all its processes."""
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = [program, "run", str(library), "--out", str(out), *options]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    whole, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {name: float(took) for name, took in STEP.findall(said)} | {WHOLE: whole, PROCESSOR: processor}


def main() -> None:
    """Read the command line, run both versions in turn and print a table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("library", type=Path)
    parser.add_argument("other")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--options", default="", help="further options of `w2w run`, in one word")
    given = parser.parse_args()
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    programs = {"other": given.other, "this": str(Path(sys.executable).with_name("w2w"))}
    spent: dict[str, list[dict[str, float]]] = {which: [] for which in programs}
    for _ in range(given.rounds):
        for which, program in programs.items():
            with tempfile.TemporaryDirectory() as folder:
                how = given.library, Path(folder) / "out", shlex.split(given.options)
                took = seconds(program, *how)
                spent[which].append(took | {AGAIN: seconds(program, *how)[PROCESSOR]})
    for step in spent["this"][0]:
        found = {
            which: median(took[step] for took in rounds)
            for which, rounds in spent.items()
            if step in rounds[0]
        }
        ratio = f"{found['this'] / found['other']:8.2f}" if "other" in found else ""
        print(f"{step:45}", *(f"{found.get(which, float('nan')):8.1f} s" for which in programs), ratio)


if __name__ == "__main__":
    main()
