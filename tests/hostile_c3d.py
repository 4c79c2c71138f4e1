# SPDX-License-Identifier: GPL-3.0-or-later
"""A reader of C3D files, in the place of ezc3d, that does what a damaged file may make one do."""

from __future__ import annotations

from pathlib import Path

PLANTED = """
import ctypes, itertools
from pathlib import Path

def c3d(path):
    kind = Path(path).stem
    with Path(__file__).with_name("begun").open("a") as begun:
        print(kind, file=begun)
    if kind == "crashes":
        ctypes.string_at(0)
    if kind == "hangs":
        ctypes.PyDLL(None).sleep(10**6)  # keeps the interpreter's lock, as C may
    if kind == "fills":
        held = [bytes(2**26) for _ in itertools.count()]
    raise ValueError("no header")
"""

KINDS = ("crashes", "fills", "hangs")


def plant(folder: Path, monkeypatch) -> Path:
    """Let processes started from now on find the reader; returns a file with a line of each time it began."""
    folder.mkdir()
    (folder / "ezc3d.py").write_text(PLANTED)
    monkeypatch.setenv("PYTHONPATH", str(folder))
    monkeypatch.syspath_prepend(folder)  # workers of loky go by it
    return folder / "begun"


def write_hostile(folder: Path, kinds: tuple[str, ...] = KINDS) -> list[Path]:
    """Files that it reads so, each by its name."""
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"{kind}.c3d" for kind in kinds]
    for file in files:
        file.write_bytes(b"\2\x50" + bytes(1022))
    return files
