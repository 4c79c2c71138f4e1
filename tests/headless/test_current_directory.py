# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing that lies in the current directory is run, whoever put it there, and whatever it is called."""

import re
import shutil
import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from ..patience import HANG_S
from .conftest import write_motions

ROOT = Path(__file__).resolve().parents[2]
DOOR = "import sys\nsys.path.append({tree!r})\nfrom w2w.headless.start import main\n\nmain()\n"
TRAP = "open({marker!r}, 'a').write(__name__ + '\\n')\nraise SystemExit(77)\n"
OWN = ("w2w", "headless", "w2w_studies", "bpy", "mathutils", "sitecustomize", "usercustomize")
NATIVE = """
#include <stdio.h>
__attribute__((constructor)) static void run(void) {
    FILE *file = fopen(MARKER, "a");
    fputs("plugin\\n", file);
    fclose(file);
}
"""
MATPLOTLIBRC = "text.usetex: True\nfont.size: 40\nfigure.facecolor: red\nbackend: module://random\n"


def lay_traps(folder, marker):
    """A file for every module that can be imported here, each of which would say that it ran.

    Also settings and a library that Matplotlib and Blender take from the current directory.
    """
    folder.mkdir(exist_ok=True)
    for name in {*sys.stdlib_module_names, *packages_distributions(), *OWN}:
        if name.isidentifier():
            (folder / f"{name}.py").write_text(TRAP.format(marker=str(marker)))
    (folder / "matplotlibrc").write_text(MATPLOTLIBRC)
    if compiler := shutil.which("cc"):
        (folder / "plugins").mkdir()
        command = [compiler, "-shared", "-fPIC", f'-DMARKER="{marker}"', "-x", "c", "-", "-o"]
        subprocess.run([*command, folder / "plugins" / "lib.so"], input=NATIVE, text=True, check=True)


@pytest.fixture
def w2w(tmp_path):
    """Runs the command as its script does, in a folder; nothing there may have run."""
    marker, door = tmp_path / "ran.txt", tmp_path / "door" / "w2w"
    door.parent.mkdir()
    door.write_text(DOOR.format(tree=str(ROOT / "blender_addon")))

    def run(folder, *arguments):
        command = [sys.executable, str(door), *map(str, arguments)]
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=HANG_S, check=False
        )
        assert not marker.exists(), marker.read_text()
        assert (done.returncode, done.stderr) == (0, ""), done.stdout + done.stderr

    run.marker = marker
    return run


def test_scene_takes_blenders_module_from_where_it_is_imported_safely():
    scene = ROOT / "blender_addon" / "w2w" / "scene"
    own = [
        file
        for file in scene.rglob("*.py")
        if re.search(r"^ *(import bpy|from bpy)\b", file.read_text(), re.M)
    ]
    assert own == [scene / "base" / "module.py"]


@pytest.mark.slow
def test_a_module_of_the_current_directory_is_not_imported(w2w, made_files, tmp_path):
    lay_traps(tmp_path / "traps", w2w.marker)
    w2w(tmp_path / "traps", "inspect", next(made_files[0].rglob("*.fbx")))


@pytest.mark.slow
def test_nothing_of_the_library_or_the_results_runs(w2w, tmp_path):
    library, out = tmp_path / "library", tmp_path / "out"
    write_motions(library, {"slow": 0.5, "fast": 2.0}, 4)
    lay_traps(library, w2w.marker)
    lay_traps(out, w2w.marker)
    w2w(library, "run", ".", "--out", out, "--patches", "8", "--workers", "2")
    assert (out / "heatmaps" / "subset.png").exists()
    assert (out / "study.blend").exists()
    w2w(out, "run", library, "--out", ".", "--patches", "8", "--window", "1")
    w2w(out, "place", ".", "--redraw", "--max", "2")
    w2w(out, "export", ".", "--for", "aeon")
    w2w(out, "report", ".")
    clip = next(library.rglob("*.npz"))
    w2w(out, "synth", clip, "--patch", "left wrist", "--out", "x.csv", "--plot", "x.png")


@pytest.mark.slow
def test_nothing_runs_in_a_demo(w2w, tmp_path):
    lay_traps(tmp_path / "traps", w2w.marker)
    w2w(tmp_path / "traps", "demo", "--out", "demo", "--clips", "2")


@pytest.mark.later
def test_python_m_runs_only_what_python_itself_imports_before(tmp_path):
    marker = tmp_path / "ran.txt"
    (tmp_path / "headless").symlink_to(ROOT / "headless")
    for name in ("random", "queue", "loky", "tempfile", "numpy", "typer"):
        (tmp_path / f"{name}.py").write_text(TRAP.format(marker=str(marker)))
    done = subprocess.run(
        [sys.executable, "-m", "headless", "sensors"], cwd=tmp_path, env={}, capture_output=True, check=False
    )
    assert not marker.exists(), marker.read_text()
    assert done.returncode == 0, done.stderr
