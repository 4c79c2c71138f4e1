# SPDX-License-Identifier: GPL-3.0-or-later
"""Which libraries W2W needs inside the Blender program, which brings numpy, and in which versions."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]

NEEDED_BY_THEM = (
    "annotated-doc", "cloudpickle", "contourpy", "cycler", "fonttools", "kiwisolver", "markdown-it-py",
    "MarkupSafe", "mdurl", "packaging", "Pygments", "pyparsing", "python-dateutil", "shellingham", "tzdata",
)  # fmt: skip
"""What the libraries in pyproject.toml need themselves; a test asks their metadata. The versions are those of
constraints.txt."""

ON_WINDOWS = ("colorama",)

PIP_ONLY = ("scikit-learn",)
"""Libraries in pyproject.toml that other classifiers than the ridge need, and not the extension."""

OTHER_VERSIONS = {
    ("contourpy", "3.11"): "1.3.2",
    ("contourpy", "3.13"): "1.3.2",
    ("matplotlib", "3.11"): "3.10.8",
    ("matplotlib", "3.13"): "3.10.8",
    ("pillow", "3.11"): "11.0.0",
    ("pillow", "3.13"): "11.0.0",
    ("scipy", "3.14"): "1.16.3",
}
"""The version to take where the constrained one is much larger, wants a newer numpy than Blender's or has no
wheel for a Python."""

PLATFORMS = {
    "linux-x64": ("manylinux2014_x86_64", "manylinux_2_28_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_12_0_arm64", "macosx_11_0_arm64"),
    "macos-x64": ("macosx_10_13_x86_64", "macosx_10_9_x86_64"),
}
"""Blender's name of a platform, and the tags of the wheels that run there."""

SPANS = {"3.11": "4.3-to-5.0", "3.13": "5.1-and-later"}
"""The Blenders that have a Python, as names of zips say them."""

PURE_TOO = ("fonttools",)
"""Libraries with compiled wheels and a pure one, which is smaller: that is taken."""

PURE = ("--platform=any", "--implementation=py", "--abi=none")

ASK = "import sys; print('w2w-python', *sys.version_info[:2])"


def versions_for(python: str, windows: bool = False) -> dict[str, str]:
    """Version of each library to install for a Python such as "3.13"."""
    names = (*dependencies(), *NEEDED_BY_THEM, *(ON_WINDOWS if windows else ()))
    left_out = {"numpy", *PIP_ONLY}
    return {
        name: OTHER_VERSIONS.get((name, python), _constrained(name)) for name in names if name not in left_out
    }


def dependencies() -> list[str]:
    """Names of the libraries in pyproject.toml."""
    project = (PROJECT / "pyproject.toml").read_text(encoding="utf-8")  # Python 3.9 has no tomllib
    listed = re.search(r"^dependencies = \[(.*?)^\]", project, re.DOTALL | re.MULTILINE)
    return re.findall(r'"([\w-]+)', listed[1])


def fetch_wheels(platform: str, python: str) -> list[Path]:
    """Download the wheels that one platform and Python need, unless they are there, and list them."""
    cache = PROJECT / ".cache" / "wheels" / platform
    versions = versions_for(python, platform.startswith("windows"))
    missing = {name for name, version in versions.items() if _cached(cache, name, version, python) is None}
    of_platform = tuple(f"--platform={tag}" for tag in PLATFORMS[platform])
    for names, tags in ((missing - {*PURE_TOO}, of_platform), (missing & {*PURE_TOO}, PURE)):
        if names:
            pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
            pip += [f"--python-version={python}", f"--dest={cache}", *tags]
            subprocess.run([*pip, *sorted(f"{name}=={versions[name]}" for name in names)], check=True)
    return sorted(_cached(cache, name, version, python) for name, version in versions.items())


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


def _cached(cache: Path, name: str, version: str, python: str) -> Path | None:
    """The wheel if the cache folder has it; projects differ in how they spell their name there."""
    tag = rf"(py\S*-none-any|cp{python.replace('.', '')}-\S+)"
    wanted = re.compile(rf"{re.sub('[-_.]', '[-_.]', name)}-{re.escape(version)}-{tag}\.whl", re.IGNORECASE)
    return next((path for path in sorted(cache.glob("*.whl")) if wanted.fullmatch(path.name)), None)


def _constrained(name: str) -> str:
    """Version of a package in constraints.txt."""
    constraints = (PROJECT / "constraints.txt").read_text(encoding="utf-8")
    found = re.search(rf"^{re.escape(name)}==(\S+)", constraints, re.MULTILINE | re.IGNORECASE)
    if found is None:
        raise SystemExit(f"constraints.txt has no version of {name}: add one")
    return found[1]
