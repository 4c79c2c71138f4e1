# SPDX-License-Identifier: GPL-3.0-or-later
"""The real Blender that `tools/real_blender.sh` sets up: the zip for it, and scripts run in its window."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

PROJECT = Path(__file__).resolve().parents[2]
SANDBOX = Path(os.environ.get("W2W_BLENDER_SANDBOX", PROJECT / ".sandbox" / "blender-4.3"))
RESULTS = PROJECT / ".cache" / SANDBOX.name
"""Reports and pictures of this Blender; the sandbox sees the folder."""

WINDOW = ("1440", "1000")
"""Pixels: no wider than the panel and two bodies beside it need, for each is drawn in software."""

TIMEOUT_S = 2400
"""A window drawn in software on a busy machine is slow; an idle one takes under four minutes."""


def inside(path: Path) -> str:
    """How the sandbox sees a path of the project."""
    return f"/project/{path.relative_to(PROJECT)}"


def newest_zip() -> Path:
    """The zip for the sandbox's Blender that was built last; skips the test where one of both is missing."""
    if not (SANDBOX / ".ready").exists():
        pytest.skip("no real Blender here: run tools/real_blender.sh first")
    python = python_version()
    zips = (PROJECT / "dist").glob(f"w2w-*-blender-of-python{python}-linux-x64.zip")
    newest = max(zips, key=lambda path: path.stat().st_mtime, default=None)
    if newest is None:
        pytest.skip(f"no extension for Python {python} here: run 'make test-window' first")
    return newest


def python_version() -> str:
    """The version of the Python that the sandbox's Blender uses, such as "3.13": Debian's own."""
    return (SANDBOX / "usr" / "bin" / "python3").readlink().name.removeprefix("python")


def run_in_window(
    script: str,
    out: Path,
    variables: Mapping[str, str] | None = None,
    shared: Path | None = None,
    window: tuple[str, str] = WINDOW,
) -> dict[str, Any]:
    """Run a script of this folder in Blender's window under Xvfb.

    Parameters
    ----------
    script : str
        Name of the file; it finds the zip in W2W_ZIP and writes report.json into the folder W2W_OUT.
    out : Path
        That folder, in the project; Blender's log goes there too.
    variables : mapping of str to str, optional
        Further environment of the script.
    shared : Path, optional
        A folder that the script sees as /shared.
    window : tuple of str
        Width and height, pixels.

    Returns
    -------
    dict
        The script's report.
    """
    out.mkdir(parents=True, exist_ok=True)
    for left in (out / "report.json", out / "pictures" / "failed.png"):
        left.unlink(missing_ok=True)
    resources = out / "resources"  # new: Blender keeps a wheel of the same name that it once installed
    shutil.rmtree(resources, ignore_errors=True)
    given = {"W2W_ZIP": inside(newest_zip()), "W2W_OUT": inside(out), **(variables or {})}
    given["BLENDER_USER_RESOURCES"] = inside(resources)
    blender = [
        "blender", "--factory-startup", "--enable-event-simulate",
        "--window-geometry", "0", "0", *window, "--python", f"/project/tests/gui/{script}",
    ]  # fmt: skip
    folders = {"W2W_BLENDER_SANDBOX": str(SANDBOX)}
    if shared is not None:
        folders["W2W_BLENDER_SHARE"] = str(shared.resolve())
    done = subprocess.run(
        [
            PROJECT / "tools" / "real_blender.sh", "run", *(f"{k}={v}" for k, v in given.items()),
            "xvfb-run", "-a", "-s", f"-screen 0 {'x'.join(window)}x24", *blender,
        ],
        env={**os.environ, **folders},
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )  # fmt: skip
    (out / "blender.log").write_text(done.stdout + done.stderr)
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    return json.loads((out / "report.json").read_text())


def is_outliner_folded(picture: Path, foot: tuple[int, int]) -> bool:
    """Whether the lower part of an Outliner, above `foot` in a picture, lists hardly any objects."""
    left, bottom = foot
    with Image.open(picture) as image:
        part = np.array(image.convert("RGB").crop((left, bottom - 130, left + 140, bottom))).astype(int)
    of_objects = (np.ptp(part, axis=-1) > 40).any(axis=1)  # lines of pixels with an icon, orange or dimmed
    return int(of_objects.sum()) < 50  # one of the armature has 16, and six patches 90
