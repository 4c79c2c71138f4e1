# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of system libraries is what Blender's module really opens, no more and no less."""

import os
import re
import subprocess
import sys
from pathlib import Path

import bpy
import pytest

from w2w.headless.system_libraries import LIBRARIES, how_to_install, missing_libraries, missing_library

ROOT = Path(__file__).resolve().parents[2]
EVERYWHERE = {"c", "m", "dl", "pthread", "rt", "util", "gcc_s", "stdc++"}
"""Of the system itself, and of the packages that Python is installed with."""

DONE_WITHOUT = {"decor-0", "wayland-client", "wayland-cursor", "wayland-egl", "iomp5", "irml", "tcm"}
"""Tried, and done without: windows under Wayland, other threading."""

BODY = """
from w2w.core.body.body import Body
from w2w.scene.base.body import add_body
add_body(Body.bundled())
"""

linux = pytest.mark.skipif(sys.platform != "linux", reason="asks Linux's dynamic linker")


@pytest.mark.slow
@linux
def test_the_list_is_what_blender_opens(tmp_path):
    subprocess.run(
        [sys.executable, "-c", BODY],
        cwd=ROOT,
        env={**os.environ, "LD_DEBUG": "files", "LD_DEBUG_OUTPUT": str(tmp_path / "linker")},
        capture_output=True,
        check=True,
    )
    said = "".join(path.read_text(errors="replace") for path in tmp_path.glob("linker*"))
    module = Path(bpy.utils.resource_path("LOCAL")).parent
    asked = re.findall(
        rf"file=(\S+) \[0\];  (?:needed by|dynamically loaded by) {re.escape(str(module))}/", said
    )
    own = {path.name for path in module.rglob("*.so*")}
    opened = {name for name in asked if "/" not in name} - own
    stems = EVERYWHERE | DONE_WITHOUT
    assert {name for name in opened if re.sub(r"^lib|\.so.*", "", name) not in stems} - {
        "ld-linux-x86-64.so.2"
    } == set(LIBRARIES)


@linux
def test_a_bare_python_finds_what_is_missing(tmp_path):
    assert missing_libraries() == []
    (tmp_path / "libGL.so.1").write_text("no library")
    done = subprocess.run(
        [sys.executable, "-I", ROOT / "blender_addon/w2w/headless/system_libraries.py"],
        env={"LD_LIBRARY_PATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "libGL.so.1=libgl1\n"
    assert how_to_install(["libXi.so.6", "libGL.so.1"]) == "sudo apt-get install -y libxi6 libgl1"


def test_blenders_last_words_are_searched_once_however_long_they_are():
    """A million letters were gone over for each of them, which took hours."""
    said = "a" * 2**20 + ".so.1" * 2**10
    assert missing_library(said) == ""
    assert "libmine.so.2 is missing" in missing_library(
        f"{said} libmine.so.2: cannot open shared object file: No such file"
    )
