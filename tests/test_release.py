# SPDX-License-Identifier: GPL-3.0-or-later
"""One name of the authors everywhere, our own citation, and a list of what waits for an address."""

import re
import sys
import tomllib
from pathlib import Path

import yaml

from w2w.core.ranking.utility import PLUG_INS
from w2w.core.reading.formats import GROUP as READERS
from w2w.headless.app import GROUP as COMMANDS

ROOT = Path(__file__).resolve().parents[1]
NAME = "The W2W authors"


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


def test_authors_have_one_name():
    manifest = tomllib.loads(text("blender_manifest.toml"))
    named = [
        tomllib.loads(text(f"{part}pyproject.toml"))["project"]["authors"]
        for part in ("", "packages/studies/")
    ]
    assert named == [[{"name": NAME}]] * 2
    assert manifest["maintainer"] == NAME
    assert re.findall(r'name: "?(The W2W \w+)', text("CITATION.cff") + text("paper/paper.md")) == [NAME] * 3


def test_we_ask_to_cite_this_software_of_this_version():
    cited, version = text("CITATION.cff"), tomllib.loads(text("blender_manifest.toml"))["version"]
    preferred = cited[cited.index("preferred-citation:") : cited.index("references:")]
    assert "type: software" in preferred
    assert cited.count(f"version: {version}\n") == 2
    assert re.search(r"^date-released: \d{4}-\d\d-\d\d$", cited, re.M)


def test_entry_points_are_named_as_the_code_names_them():
    named = re.findall(
        r"`(w2w\.(?:command|classifier|reader)\w*)`", text("CHANGELOG.md") + text("ARCHITECTURE.md")
    )
    assert set(named) == {COMMANDS, READERS, PLUG_INS}


def test_conda_s_recipe_asks_for_what_pip_does():
    project = tomllib.loads(text("pyproject.toml"))
    recipe, asked = yaml.safe_load(text("release/conda/recipe.yaml")), project["project"]
    run = {each.replace("matplotlib-base", "matplotlib") for each in recipe["requirements"]["run"]}
    pythons = {each for each in run if each.startswith("python >")}
    needed = {*asked["dependencies"], *asked["optional-dependencies"]["web"]}
    assert run - pythons == {each.replace(">=", " >=") for each in needed}
    assert pythons == {"python " + asked["requires-python"].replace("3.11", "${{ python_min }}")}
    assert recipe["context"]["version"] == tomllib.loads(text("blender_manifest.toml"))["version"]
    assert dict(line.split(" = ") for line in recipe["build"]["python"]["entry_points"]) == asked["scripts"]
    builds = {each.replace(" >=", ">=") for each in recipe["requirements"]["host"]}
    assert builds >= set(project["build-system"]["requires"])
    assert recipe["about"]["license"] == asked["license"]
    assert recipe["about"]["license_file"] == asked["license-files"]
    assert text("release/conda/recipe.yaml").count("HASH_OF_THE_SDIST") == 1
    assert recipe["source"]["url"] == "ADDRESS_OF_THE_SDIST"  # written in once the sdist has one


def test_what_waits_for_an_address_is_said(monkeypatch):
    monkeypatch.setattr(sys, "path", [str(ROOT / "tools"), *sys.path])
    import make_release

    urls = tomllib.loads(text("pyproject.toml"))["project"].get("urls")
    assert bool(make_release.still_open()) == (urls is None)
