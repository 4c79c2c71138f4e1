# SPDX-License-Identifier: GPL-3.0-or-later
"""How long W2W takes to start, against other programs of Python.

    python -m benchmarks.start [--times 9]

Each starts in turn, again and again; printed are medians of processor time and their ratios to pytest's.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

TYPER = "import typer\napp = typer.Typer()\napp.command()(lambda: None)\napp.callback()(lambda: None)\napp()"

W2W = str(Path(sys.executable).with_name("w2w"))

STARTS = {
    "pytest --version": ["-m", "pytest", "--version"],
    "an empty command of typer, --help": ["-c", TYPER, "--help"],
    "w2w --help": [W2W, "--help"],
    "w2w run --help": [W2W, "run", "--help"],
    "w2w status": [W2W, "status", "."],
    "w2w run, until it says that a folder is empty": [W2W, "run", ".", "--out", "results"],
    "import w2w": ["-c", "import w2w"],
    "import w2w, and its functions": ["-c", "import w2w; w2w.load, w2w.rank"],
    "import scipy.spatial": ["-c", "import scipy.spatial"],
}


def processor_s(arguments: list[str], folder: str) -> float:
    """Seconds of the processor of one start, its children's included."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, *arguments], cwd=folder, env={**os.environ, "COLUMNS": "100"}, capture_output=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--times", type=int, default=9)
    times = parser.parse_args().times
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "empty").mkdir()
        spent = [{name: processor_s(given, folder) for name, given in STARTS.items()} for _ in range(times)]
    middle = {name: median(one[name] for one in spent) for name in STARTS}
    baseline = next(iter(middle.values()))
    for name, seconds in middle.items():
        print(f"{name}: {seconds:.2f} s, {seconds / baseline:.2f} of pytest's")


if __name__ == "__main__":
    main()
