# SPDX-License-Identifier: GPL-3.0-or-later
"""Without Blender's module: what needs it says how to get it, what does not works."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from w2w.headless.blender import NoBlenderError, needs_blender
from w2w.headless.system_libraries import missing_library

pytestmark = pytest.mark.usefixtures("few_orders")

ROOT = Path(__file__).resolve().parents[2]
NOT_THERE = "cannot open shared object file: No such file or directory"
NOT_INSTALLED = "bpy, is not installed. In W2W's folder run 'make setup'"
BLOCKED = {
    "not installed": "raise ModuleNotFoundError(\"No module named 'bpy'\", name='bpy')",
    "library missing": f"raise ImportError('libXi.so.6: {NOT_THERE}')",
}
SAID = {
    "not installed": NOT_INSTALLED,
    "library missing": "the system library libXi.so.6 is missing; on Debian and Ubuntu run: "
    "sudo apt-get install -y libxi6",
}


def w2w_process(folder, arguments, blocked="not installed"):
    """Python in a process whose `bpy`, and its workers', is one that cannot be imported."""
    package = folder / "blocked" / "bpy"
    package.mkdir(parents=True, exist_ok=True)
    (package / "__init__.py").write_text(BLOCKED[blocked])
    done = subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": f"{package.parent}{os.pathsep}{ROOT}", "COLUMNS": "400"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "Traceback" not in done.stdout + done.stderr, done.stdout + done.stderr
    return done


def w2w(folder, *arguments, blocked="not installed"):
    """What the command says there, and its exit code."""
    done = w2w_process(folder, ["-m", "headless", *arguments], blocked)
    return done.returncode, " ".join((done.stdout + done.stderr).split())


@pytest.fixture
def clip(tmp_path):
    """One of two clips of each of two activities."""
    for file in ("running/one.fbx", "running/two.fbx", "walking/one.fbx", "walking/two.fbx"):
        path = tmp_path / "library" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("; FBX 7.3.0 project file\n")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("command", [("inspect",), ("run", "--out", "out", "--patches", 8)])
def test_a_missing_system_library_is_named(tmp_path, clip, command):
    about = clip if command[0] == "inspect" else clip.parents[1]
    code, output = w2w(tmp_path, *command, about, blocked="library missing")
    assert code == 1
    assert SAID["library missing"] in output


ONE_AFTER_ANOTHER = """
import json, sys
from typer.testing import CliRunner
from w2w.headless.app import APP
for arguments in json.loads(sys.argv[1]):
    result = CliRunner().invoke(APP, arguments)
    print(json.dumps([result.exit_code, " ".join(result.output.split()), str(result.exception)]))
"""


@pytest.mark.slow
def test_what_needs_it_says_how_to_get_it_and_what_does_not_works(tmp_path, clip, drawn_results):
    results = str(drawn_results)
    need_it = [
        ["run", "library", "--out", "out", "--patches", "8", "--workers", "1"],
        ["inspect", str(clip)],
        ["synth", str(clip), "--patch", "left wrist", "--out", "x.csv"],
        ["demo-library", "made", "--clips", "1"],
        ["run", "library", "--out", "bodies", "--bodies", "body.fbx"],
    ]
    do_not = [["sensors"], ["tables", results, "--out", "t.csv"], ["status", "library"]]
    done = w2w_process(tmp_path, ["-c", ONE_AFTER_ANOTHER, json.dumps([*need_it, *do_not])])
    codes, outputs, raised = zip(*map(json.loads, done.stdout.splitlines()), strict=True)
    assert codes == (1, 1, 1, 1, 1, 0, 0, 2), outputs
    assert "No result: Blender's Python module" in outputs[0]
    for output, error in list(zip(outputs, raised, strict=True))[: len(need_it)]:
        assert NOT_INSTALLED in output + error  # one that a command raises is said by the program, as above
    assert "No run was started" in outputs[-1]
    assert not list((tmp_path / "out/.w2w/clips").glob("*.json"))  # or the next run would not read the clip


@pytest.mark.slow
def test_npz_motions_need_it_for_study_blend_only(tmp_path, motions):
    out = tmp_path / "out"
    code, output = w2w(tmp_path, "run", motions, "--out", out, "--patches", 8, "--workers", 1, "--log-json")
    assert code == 0, output
    assert json.loads((out / "summary.json").read_text())["clips"] == {
        "found": 8,
        "used": 8,
        "ranked": 8,
        "skipped": 0,
    }
    assert (out / "report.html").is_file()
    assert (out / "heatmaps" / "mean.png").is_file()
    assert NOT_INSTALLED in output
    assert output.count('"event": "not_drawn"') == 1
    code, output = w2w(tmp_path, "place", out)
    assert code == 0, output


def test_another_import_error_is_not_blender():
    with pytest.raises(ImportError, match="nothing_of_the_kind") as raised, needs_blender():
        import nothing_of_the_kind  # noqa: F401
    assert not isinstance(raised.value, NoBlenderError)


def test_the_line_to_run_names_the_package():
    text = f"Couldn't open libGL.so.1: libGL.so.1: {NOT_THERE}"
    assert missing_library(text).startswith("the system library libGL.so.1 is missing; on Debian and Ubuntu")
    assert "apt-get install -y libgl1" in missing_library(text)
    assert "install the package that brings it" in missing_library(
        "libq.so.2: cannot open shared object file"
    )
    assert missing_library("Segmentation fault") == ""
