# SPDX-License-Identifier: GPL-3.0-or-later
"""Check the extension's zips by the rules of Blender's Extensions Platform and by our own.

    python tools/check_zip.py ZIP ...

`tools/build_extension.py` checks every zip it builds, after Blender's own tool has validated the manifest.
"""

from __future__ import annotations

import email
import io
import re
import sys
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

try:
    from blender_wheels import PLATFORMS, SPANS
except ModuleNotFoundError:  # imported by a test
    from tools.blender_wheels import PLATFORMS, SPANS

LARGEST = 61e6
"""Bytes of a zip: who tries the extension waits for its download."""

RELEASED = {"3.11", "3.13"}
"""Pythons of Blender's own releases; a distribution's newer one has larger wheels."""

TAGLINE = 64
"""Characters of a tagline on the platform."""

LEFT_TO_PIP = ("smpl_numbering.npz",)
"""Templates that the extension does not hold: the platform does not take their licence, CC BY 4.0."""

ACCEPTED = {
    "GPL-2.0-or-later", "GPL-3.0-or-later", "LGPL-2.1-or-later", "LGPL-3.0-or-later", "BSD-1-Clause",
    "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CC0-1.0", "MIT", "MIT-0", "MPL-2.0", "Pixar", "Zlib",
}  # fmt: skip
"""Licences that the platform takes (docs.blender.org/manual/en/latest/advanced/extensions/licenses.html)."""

DOOR = {"blender_manifest.toml", "__init__.py", "LICENSE"}
DOOR_LINES = 40
"""Lines, blank ones aside, of the zip's `__init__.py`, which hands over to the package in the wheels."""

TAGS = {"linux": "manylinux", "windows": "win_amd64", "macos": "macosx"}
PIP_ONLY = {"scikit-learn"}
"""What W2W's own metadata asks for and the extension does without."""

BLENDERS_OWN = {"numpy"}
LEFT_OUT = ("scikit_learn", "pydantic", "cmap", "pygeodesic", "torch")

PROCESS_WIDE = re.compile(r"os\.environ\[[^]]*\]\s*=[^=]|os\.environ\.(update|setdefault|pop)|os\.putenv")
"""Code that changes the environment of all of Blender."""


def unpacked(zipped: Path | BinaryIO) -> dict[str, bytes]:
    """The files of a zip or wheel, by their names in it."""
    with zipfile.ZipFile(zipped) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def problems(path: Path) -> list[str]:
    """Every rule that a zip breaks, as a sentence; the zip's name tells its platform and Python."""
    platform = next(platform for platform in PLATFORMS if path.stem.endswith(f"-{platform}"))
    blenders = path.stem.removesuffix(f"-{platform}").partition("-blender-")[2]
    python = {span: python for python, span in SPANS.items()}.get(
        blenders, blenders.removeprefix("of-python")
    )
    files = unpacked(path)
    with zipfile.ZipFile(path) as archive:
        twice = len(archive.namelist()) - len(files)
    wheels = {Path(name).name: content for name, content in files.items() if name.endswith(".whl")}
    manifest = tomllib.loads(files["blender_manifest.toml"].decode())
    found = [f"{twice} files are in it twice"] if twice else []
    if python in RELEASED and path.stat().st_size > LARGEST:
        found.append(f"it has {path.stat().st_size / 1e6:.1f} MB, more than {LARGEST / 1e6:.0f}")
    for rule in (
        _of_the_manifest(manifest, platform, {*wheels}),
        _of_the_door(files),
        _of_the_wheels({*wheels}, platform, python),
        _of_our_wheel(wheels),
        _of_what_is_needed(wheels, platform),
    ):
        found += rule
    return found


def _of_the_manifest(manifest: dict, platform: str, wheels: set[str]) -> Iterator[str]:
    if manifest.get("platforms") != [platform]:
        yield f"its manifest names the platforms {manifest.get('platforms')}"
    if {Path(name).name for name in manifest.get("wheels", ())} != wheels:
        yield "its manifest names other wheels than it holds"
    if not all(re.match(r"\d{4}(-\d{4})? \S", one) for one in manifest.get("copyright", [""])):
        yield "its manifest needs copyright, each a year and a name"
    if len(manifest["tagline"]) > TAGLINE or not manifest["tagline"][-1].isalnum():
        yield f"its tagline has more than {TAGLINE} characters or ends in punctuation"
    if manifest["license"][0] != "SPDX:GPL-3.0-or-later":
        yield "its manifest names another licence first"
    for licence in manifest["license"]:
        if licence.removeprefix("SPDX:") not in ACCEPTED:
            yield f"its manifest names {licence}, which the platform does not take"


def _of_the_door(files: dict[str, bytes]) -> Iterator[str]:
    others = {name for name in files if not name.startswith("wheels/")} ^ DOOR
    if others:
        yield f"beside wheels it has, or lacks, {', '.join(sorted(others))}"
    code = files.get("__init__.py", b"").decode()
    if sum(map(bool, map(str.strip, code.splitlines()))) > DOOR_LINES or "sys.path" in code:
        yield "its __init__.py does more than hand on, or edits sys.path"


def _of_the_wheels(wheels: set[str], platform: str, python: str) -> Iterator[str]:
    tag, ours = TAGS[platform.split("-")[0]], f"-cp{python.replace('.', '')}-"
    for wheel in sorted(wheels):
        if wheel.lower().startswith(LEFT_OUT):
            yield f"{wheel} stays out of the zip"
        if "-none-any" not in wheel and (tag not in wheel or not (ours in wheel or "-abi3-" in wheel)):
            yield f"{wheel} is for another platform or Python"


def _of_our_wheel(wheels: dict[str, bytes]) -> Iterator[str]:
    own = [content for name, content in wheels.items() if name.startswith("where_to_wear-")]
    if len(own) != 1:
        yield "W2W is not one wheel among the others"
        return
    content = unpacked(io.BytesIO(own[0]))
    if {name.split("/")[0] for name in content if ".dist-info/" not in name} != {"w2w"}:
        yield "W2W's wheel installs other packages than w2w"
    for name, code in content.items():
        in_window = name.endswith(".py") and not name.startswith("w2w/headless")
        if name.startswith("w2w/web") or (name.endswith("entry_points.txt") and b"w2w.web" in code):
            yield f"{name} belongs to the web app"
        if in_window and PROCESS_WIDE.search(code.decode()):
            yield f"{name} changes the environment of all of Blender"
    for name in LEFT_TO_PIP:
        if f"w2w/templates/{name}" in content:
            yield f"W2W's wheel holds {name}, whose licence the platform does not take"
    for name in ("w2w/report/templates/page.html", "w2w/templates/demo.npz"):
        if name not in content:
            yield f"W2W's wheel lacks {name}"


def _of_what_is_needed(wheels: dict[str, bytes], platform: str) -> Iterator[str]:
    needed, there = set(), {*BLENDERS_OWN, *PIP_ONLY}
    given = {"extra": "", "platform_system": "Windows" if platform.startswith("windows") else "Linux"}
    for wheel in wheels.values():
        with zipfile.ZipFile(io.BytesIO(wheel)) as content:
            (about,) = [name for name in content.namelist() if name.endswith(".dist-info/METADATA")]
            metadata = email.message_from_bytes(content.read(about))
        there.add(canonicalize_name(metadata["Name"]))
        for requirement in map(Requirement, metadata.get_all("Requires-Dist", [])):
            if requirement.marker is None or requirement.marker.evaluate(given):
                needed.add(canonicalize_name(requirement.name))
    if needed - there:
        yield f"its wheels need {', '.join(sorted(needed - there))}"


def main() -> None:
    """Print what is wrong with each zip; exit code 1 where anything is."""
    found = [f"{path}: {problem}" for path in map(Path, sys.argv[1:]) for problem in problems(path)]
    print("\n".join(found), end="\n" * bool(found))
    raise SystemExit(bool(found))


if __name__ == "__main__":
    main()
