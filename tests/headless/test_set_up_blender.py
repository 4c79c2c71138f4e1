# SPDX-License-Identifier: GPL-3.0-or-later
"""`make setup BLENDER=...` asks the program for its Python and says what is wrong where none answers."""

import re
import subprocess
import sys
from importlib.metadata import files, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from w2w.headless.blender import LIBRARIES

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))
from blender_wheels import PIP_ONLY, ask_blender, dependencies, versions_for  # noqa: E402


def answering(folder, answer):
    program = folder / "blender"
    program.write_text(f"#!/bin/sh\necho Blender 9.9\necho '{answer}'\necho Blender quit\n")
    program.chmod(0o755)
    return str(program)


def test_a_blender_says_its_python(tmp_path):
    assert ask_blender(answering(tmp_path, "w2w-python 3 13")) == "3.13"


@pytest.mark.parametrize("program", ["no_such_program", "true"])
def test_what_is_no_blender_is_said_and_nothing_is_made(program):
    before = {path.name for path in ROOT.iterdir()}
    done = subprocess.run(
        ["make", "setup", f"BLENDER={program}"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode != 0
    assert f"{program} cannot be started" in done.stderr or f"{program} does not answer" in done.stderr
    assert "Traceback" not in done.stderr
    assert {path.name for path in ROOT.iterdir()} == before


def canonical(names):
    return {re.sub("[-_.]+", "-", name).lower() for name in names}


def with_what_they_need(names):
    found = set()
    while names := canonical(names) - found:
        found |= names
        needs = [Requirement(line) for name in names for line in requires(name) or ()]
        names = {need.name for need in needs if need.marker is None or need.marker.evaluate({"extra": ""})}
    return found


def test_start_up_looks_for_the_libraries_that_the_extension_brings():
    brought = canonical(dependencies()) - canonical(PIP_ONLY)
    imports = [{file.parts[0].removesuffix(".py") for file in files(name) or ()} for name in brought]
    assert sorted(map(list, [names & {*LIBRARIES} for names in imports])) == [[name] for name in LIBRARIES]


@pytest.mark.skipif(sys.platform == "win32", reason="a terminal's colours need one more there")
def test_a_blender_gets_them_and_all_that_they_need():
    assert canonical(versions_for("3.11")) == with_what_they_need({*dependencies()} - {*PIP_ONLY}) - {"numpy"}


def test_each_python_gets_wheels_that_there_are_for_it():
    assert versions_for("3.11")["matplotlib"] < versions_for("3.14")["matplotlib"]  # numpy of Blender 4.5
    assert versions_for("3.14")["scipy"] != versions_for("3.13")["scipy"]
