# SPDX-License-Identifier: GPL-3.0-or-later
"""What the extensions platform asks for beside the zip is there, in the sizes that it asks for."""

import tomllib
from pathlib import Path

import pytest
from PIL import Image

from tools.check_zip import ACCEPTED, LEFT_TO_PIP
from w2w.core.adopt.topology import NUMBERING

ROOT = Path(__file__).resolve().parents[1]

PICTURES = {"icon": (256, 256), "featured": (1920, 1080)} | {f"preview_{n}": (1920, 1080) for n in (1, 2, 3)}


@pytest.mark.parametrize("name", PICTURES)
def test_pictures_have_the_platform_s_sizes(name: str) -> None:
    with Image.open(ROOT / "release" / f"{name}.png") as picture:
        assert picture.size == PICTURES[name]
        assert len(picture.convert("RGB").getcolors(2**24)) > 1000  # something is on it


def test_the_listing_says_what_the_manifest_says() -> None:
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    listing = (ROOT / "release" / "listing.md").read_text(encoding="utf-8")
    for value in (manifest["name"], manifest["tagline"], ", ".join(manifest["tags"])):
        assert f" {value} |" in listing
    assert len(manifest["tagline"]) <= 64
    assert not manifest["tagline"].endswith(".")
    assert manifest["license"][0] == "SPDX:GPL-3.0-or-later"
    assert {name.removeprefix("SPDX:") for name in manifest["license"]} <= ACCEPTED
    assert all(year_and_name[:4].isdigit() for year_and_name in manifest["copyright"])


def test_what_the_zip_leaves_to_pip_is_no_part_of_what_makes_signals() -> None:
    assert (NUMBERING.name,) == LEFT_TO_PIP
