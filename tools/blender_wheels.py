# SPDX-License-Identifier: GPL-3.0-or-later
"""Which libraries W2W needs inside the Blender program, which brings numpy, and in which versions."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]

PURE_WHEELS = (
    "annotated-doc", "annotated-types", "cloudpickle", "cmap", "cycler", "filelock", "fonttools", "Jinja2",
    "joblib", "loky", "markdown-it-py", "mdurl", "packaging", "plyfile", "pydantic", "Pygments", "pyparsing",
    "python-dateutil", "rich", "shellingham", "threadpoolctl", "trimesh", "typer", "typing-inspection",
    "typing_extensions", "tzdata",
)  # fmt: skip
COMPILED_WHEELS = (
    "contourpy", "kiwisolver", "MarkupSafe", "matplotlib", "pillow", "pydantic_core", "scikit-learn",
    "scipy",
)  # fmt: skip
"""What the extension and its command import beyond numpy, and what these need; the versions stand in
constraints.txt."""

WINDOWS_WHEELS = ("colorama",)

OTHER_VERSIONS = {
    ("contourpy", "3.11"): "1.3.2",
    ("contourpy", "3.13"): "1.3.2",
    ("matplotlib", "3.11"): "3.10.8",
    ("matplotlib", "3.13"): "3.10.8",
    ("scipy", "3.14"): "1.16.3",
}
"""Where the constrained version has no wheel for a Python, or wants a newer numpy than Blender 4.2 has
(1.24): the one to take. Pythons that share a zip have the same: see
`shipped_name`."""

PLATFORMS = {
    "linux-x64": ("manylinux2014_x86_64", "manylinux_2_28_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_12_0_arm64", "macosx_11_0_arm64"),
    "macos-x64": ("macosx_10_13_x86_64", "macosx_10_9_x86_64"),
}
"""Blender's name of a platform, and the tags of the wheels that run there."""

ASK = "import sys; print('w2w-python', *sys.version_info[:2])"


def versions_for(python: str, names: tuple[str, ...] = PURE_WHEELS + COMPILED_WHEELS) -> dict[str, str]:
    """Version of each library for a Python such as "3.13"."""
    return {name: OTHER_VERSIONS.get((name, python), _constrained(name)) for name in names}


def fetch_wheels(platform: str, pythons: tuple[str, ...]) -> list[Path]:
    """Download the wheels that one platform needs, unless they are there, and list them."""
    cache = PROJECT / ".cache" / "wheels" / platform
    pure = PURE_WHEELS + (WINDOWS_WHEELS if platform.startswith("windows") else ())
    any_platform = ["--platform=any", "--implementation=py", "--abi=none", f"--python-version={pythons[0]}"]
    wheels = [
        _fetch(cache, name, version, r"py\S*-none-any", any_platform)
        for name, version in versions_for(pythons[0], pure).items()
    ]
    for python in pythons:
        tags = [*(f"--platform={tag}" for tag in PLATFORMS[platform]), f"--python-version={python}"]
        tag = rf"cp{python.replace('.', '')}-\S+"
        for name, version in versions_for(python, COMPILED_WHEELS).items():
            wheels.append(_fetch(cache, name, version, tag, tags))
    return sorted(wheels)


def shipped_name(wheel: str, oldest: str) -> str:
    """Name of a wheel in a zip whose oldest Python is such as "3.11".

    Blender 4.2 does not ask which Python a wheel is for: of a library's wheels it takes the highest version,
    and of one version the name that sorts last. With a build tag all but the oldest Python's sort before.
    Later Blenders take the wheel for their Python.
    """
    name, version, rest = wheel.split("-", 2)
    newer = rest.startswith("cp") and not rest.startswith(f"cp{oldest.replace('.', '')}-")
    return f"{name}-{version}-1-{rest}" if newer else wheel


def ask_blender(blender: str) -> str:
    """The version of a Blender program's own Python, such as "3.13".

    Raises
    ------
    SystemExit
        If the program does not answer as a Blender does.
    """
    command = [blender, "--background", "--factory-startup", "--python-expr", ASK]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise SystemExit(f"{blender} cannot be started: {error.strerror}") from error
    answer = re.search(r"^w2w-python (\d+) (\d+)$", done.stdout, re.MULTILINE)
    if answer is None:
        said = (done.stdout + done.stderr)[-1000:].strip() or "it says nothing"
        raise SystemExit(f"{blender} does not answer as a Blender does: {said}")
    return f"{answer[1]}.{answer[2]}"


def _fetch(cache: Path, name: str, version: str, tag: str, options: list[str]) -> Path:
    """One wheel, from the cache folder or downloaded to it."""
    if (wheel := _cached(cache, name, version, tag)) is None:
        pip = [
            sys.executable,
            "-m",
            "pip",
            "download",
            "--quiet",
            "--no-deps",
            "--only-binary=:all:",
            *options,
        ]
        subprocess.run([*pip, f"{name}=={version}", f"--dest={cache}"], check=True)
        wheel = _cached(cache, name, version, tag)
    return wheel


def _cached(cache: Path, name: str, version: str, tag: str) -> Path | None:
    """The wheel if the cache folder has it; projects differ in how they spell their name there."""
    wanted = re.compile(rf"{re.sub('[-_.]', '[-_.]', name)}-{re.escape(version)}-{tag}\.whl", re.IGNORECASE)
    return next((path for path in sorted(cache.glob("*.whl")) if wanted.fullmatch(path.name)), None)


def _constrained(name: str) -> str:
    """Version of a package in constraints.txt."""
    constraints = (PROJECT / "constraints.txt").read_text(encoding="utf-8")
    found = re.search(rf"^{re.escape(name)}==(\S+)", constraints, re.MULTILINE)
    if found is None:
        raise SystemExit(f"constraints.txt has no version of {name}: add one")
    return found[1]
