# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a Blender program's Python finds W2W's libraries, and what it says where there are none."""

import sys

import pytest

from w2w.headless import blender as from_blender, start

MISSING = "a_library_that_nobody_has"


@pytest.fixture
def tree(monkeypatch, tmp_path):
    monkeypatch.setattr(from_blender, "ROOT", tmp_path)
    monkeypatch.setattr(from_blender, "LIBRARIES", ("typer", MISSING))
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys.modules["bpy"].utils, "user_resource", lambda _: str(tmp_path / "extensions"))
    return tmp_path


@pytest.fixture(autouse=True)
def blender():
    pytest.importorskip("bpy")


def version():
    return f"python{sys.version_info.major}.{sys.version_info.minor}"


def test_the_extension_comes_before_what_make_set_up(tree):
    own = tree / f".venv-blender-{version()}"
    extension = tree / "extensions" / ".local" / "lib" / version() / "site-packages"
    for folder in (own, extension):
        (folder / MISSING).mkdir(parents=True)
        (folder / MISSING / "__init__.py").touch()
    from_blender.find_libraries()
    assert sys.path[-1] == str(extension)


def test_a_folder_that_lacks_one_is_not_taken(tree):
    (tree / ".venv" / "lib" / version() / "site-packages" / "another").mkdir(parents=True)
    own = tree / f".venv-blender-{version()}"
    (own / MISSING).mkdir(parents=True)
    (own / MISSING / "__init__.py").touch()
    from_blender.find_libraries()
    assert sys.path[-1] == str(own)


def test_where_there_are_none_it_says_the_command_that_gets_them(tree, monkeypatch):
    (tree / "Makefile").touch()
    monkeypatch.setattr(from_blender, "_program", lambda: "/opt/blender 5/blender")
    with pytest.raises(SystemExit) as ended:
        from_blender.find_libraries()
    assert f"make -C {tree} setup BLENDER='/opt/blender 5/blender'" in ended.value.code


@pytest.mark.usefixtures("tree")
def test_an_installed_extension_without_its_wheels_says_what_it_lacks(capsys):
    assert start.run_arguments(["status", "OUT"]) == 1
    said = capsys.readouterr().err
    assert MISSING in said
    assert "install the extension from a zip" in said


def test_the_command_gives_the_exit_code(tmp_path, capsys):
    assert start.run_arguments(["status", str(tmp_path)]) == 2
    assert start.run_arguments(["--help"]) == 0
    assert "blender --command w2w" in capsys.readouterr().out
