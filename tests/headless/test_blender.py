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
    for activity in ("running", "walking"):
        folder = tmp_path / "library" / activity
        folder.mkdir(parents=True)
        for name in ("one.fbx", "two.fbx"):
            (folder / name).write_text("; FBX 7.3.0 project file\n")
    return folder / "one.fbx"


@pytest.mark.parametrize("blocked", BLOCKED)
def test_a_run_of_files_that_blender_reads(tmp_path, clip, blocked):
    out = tmp_path / "out"
    code, output = w2w(tmp_path, "run", clip.parents[1], "--out", out, "--patches", 8, blocked=blocked)
    assert code == 1
    assert "No result: Blender's Python module" in output
    assert SAID[blocked] in output
    assert not list((out / ".w2w" / "clips").glob("*.json"))  # or the next run would not read the clip


@pytest.mark.parametrize(
    "arguments",
    [
        ("inspect", "CLIP"),
        pytest.param(("synth", "CLIP", "--patch", "left wrist", "--out", "x.csv"), marks=pytest.mark.slow),
        pytest.param(("demo-library", "library", "--clips", "1"), marks=pytest.mark.slow),
        ("run", "library", "--out", "out", "--bodies", "body.fbx"),
    ],
    ids=lambda arguments: arguments[0],
)
def test_commands_that_need_it(tmp_path, clip, arguments):
    code, output = w2w(tmp_path, *(str(clip) if word == "CLIP" else word for word in arguments))
    assert code == 1
    assert NOT_INSTALLED in output


ONE_AFTER_ANOTHER = """
import json, sys
from typer.testing import CliRunner
from w2w.headless.app import APP
for arguments in json.loads(sys.argv[1]):
    result = CliRunner().invoke(APP, arguments)
    print(json.dumps([result.exit_code, result.output]))
"""


def test_commands_that_do_not(tmp_path, drawn_results):
    results = str(drawn_results)
    commands = [
        ["sensors"],
        ["tables", results, "--out", str(tmp_path / "t.csv")],
        ["report", results],
        ["status", str(tmp_path)],
    ]
    done = w2w_process(tmp_path, ["-c", ONE_AFTER_ANOTHER, json.dumps(commands)])
    codes, outputs = zip(*map(json.loads, done.stdout.splitlines()), strict=True)
    assert codes == (0, 0, 0, 2), outputs
    assert "No run was started" in " ".join(outputs[3].split())


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
