# SPDX-License-Identifier: GPL-3.0-or-later
"""`make setup BLENDER=...` asks the program for its Python and says what is wrong where none answers."""

import re
import subprocess
import sys
from importlib.metadata import packages_distributions, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import w2w

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))
from blender_wheels import ask_blender, dependencies, shipped_name, versions_for  # noqa: E402


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


def test_start_up_looks_for_the_libraries_that_pip_installs():
    distributions = packages_distributions()
    assert canonical(distributions[name][0] for name in w2w.LIBRARIES) == canonical(dependencies())


@pytest.mark.skipif(sys.platform == "win32", reason="a terminal's colours need one more there")
def test_a_blender_gets_them_and_all_that_they_need():
    assert canonical(versions_for("3.11")) == with_what_they_need(dependencies()) - {"numpy"}


def test_each_python_gets_wheels_that_there_are_for_it():
    assert versions_for("3.11")["matplotlib"] < versions_for("3.14")["matplotlib"]  # numpy of Blender 4.2
    assert versions_for("3.14")["scipy"] != versions_for("3.13")["scipy"]


def test_of_the_wheels_in_a_zip_blender_4_2_takes_those_of_its_python():
    assert versions_for("3.11") == versions_for("3.13")  # it would take the higher version
    theirs = "scipy-1.15.3-cp313-cp313-manylinux_2_17_x86_64.whl"
    ours, pure = theirs.replace("cp313", "cp311"), "rich-15.0.0-py3-none-any.whl"
    assert shipped_name(ours, "3.11") == ours > shipped_name(theirs, "3.11")
    assert shipped_name(theirs, "3.11") == "scipy-1.15.3-1-cp313-cp313-manylinux_2_17_x86_64.whl"
    assert shipped_name(pure, "3.11") == pure
    assert shipped_name(theirs, "3.13") == theirs
