# SPDX-License-Identifier: GPL-3.0-or-later
"""Where clips' files lie, on a file system whose calls take a while, as over a network.

A flat folder, 256 sub-folders, and zips of 128 clips that a worker fills: what each clip's three files cost
to write, and what it costs to see that they are there. `strace` delays each call that names a file.

    python -m benchmarks.clip_folders SCRATCH [--clips 400] [--delay-us 1000]
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from zipfile import ZipFile

from w2w.core.files import write_npz
from w2w.core.study.clip_files import divide, features_file, motion_file, signals_file

PER_ZIP = 128
CONTENT = {"values": [1.0] * 4000}
PLACES = (motion_file, signals_file, features_file)


def write_files(out: Path, clips: list[str]) -> None:
    """Each clip's files by themselves, each under a temporary name first."""
    for clip in clips:
        for place in PLACES:
            write_npz(place(out, clip), CONTENT)


def check_files(out: Path, clips: list[str]) -> None:
    """What a resume asks of each file."""
    for clip in clips:
        for place in PLACES:
            os.stat(place(out, clip))  # noqa: PTH116 - as the resume does


def write_zips(out: Path, clips: list[str]) -> None:
    """The files of some clips in one zip, which is renamed when it is full."""
    one = out / "one.npz"
    write_npz(one, CONTENT)
    data = one.read_bytes()
    for start in range(0, len(clips), PER_ZIP):
        with ZipFile(out / "part.zip", "w") as archive:
            for clip in clips[start : start + PER_ZIP]:
                for place in PLACES:
                    archive.writestr(f"{place.__name__}/{clip}.npz", data)
        (out / "part.zip").replace(out / f"{start}.zip")


def check_zips(out: Path, clips: list[str]) -> None:
    """What a resume would ask of each zip."""
    for start in range(0, len(clips), PER_ZIP):
        os.stat(out / f"{start}.zip")  # noqa: PTH116


def timed(work: Callable[[Path, list[str]], None], out: Path, clips: list[str]) -> float:
    """Milliseconds a clip."""
    start = time.perf_counter()
    work(out, clips)
    return 1e3 * (time.perf_counter() - start) / len(clips)


def measure(scratch: Path, n_clips: int) -> None:
    """Print a row for each way."""
    clips = [f"clip_{number}" for number in range(n_clips)]
    base: tuple[float, float] | None = None
    ways = (("flat", write_files, check_files), ("sub-folders", write_files, check_files),
            (f"zips of {PER_ZIP}", write_zips, check_zips))  # fmt: skip
    print("| way | to write, ms a clip | against flat | to check, ms a clip | against flat |")
    print("| --- | --- | --- | --- | --- |")
    for name, write, check in ways:
        out = scratch / name
        for folder in ("motions", "signals", ".w2w/features"):
            (out / folder).mkdir(parents=True)
            if name == "sub-folders":
                divide(out / folder)
        found = timed(write, out, clips), timed(check, out, clips)
        base = base or found
        cells = (f"{ms:.2f} | {ms / flat:.2f}" for ms, flat in zip(found, base, strict=True))
        print(f"| {name} | {' | '.join(cells)} |")
        shutil.rmtree(out)


def main() -> None:
    """Run under strace where a delay is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scratch", type=Path)
    parser.add_argument("--clips", type=int, default=400)
    parser.add_argument("--delay-us", type=int, default=0)
    asked = parser.parse_args()
    if not asked.delay_us:
        measure(asked.scratch, asked.clips)
        return
    own = [sys.executable, "-m", "benchmarks.clip_folders", str(asked.scratch), "--clips", str(asked.clips)]
    inject = f"inject=openat,newfstatat,stat,lstat,rename,unlink,mkdir:delay_enter={asked.delay_us}"
    subprocess.run(["strace", "-f", "-qq", "-o", "/dev/null", "-e", inject, *own], check=True)


if __name__ == "__main__":
    main()
