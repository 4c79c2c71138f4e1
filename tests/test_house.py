# SPDX-License-Identifier: GPL-3.0-or-later
"""House rules that no linter has: sizes, private names, imports relative inside a package."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = {"w2w": ROOT / "blender_addon/w2w", "w2w_studies": ROOT / "packages/studies/w2w_studies"}
OTHERS = tuple(ROOT / folder for folder in ("headless", "tools", "benchmarks"))

FILE, FUNCTION = 350, 60
"""Lines that a file may have, and a function without its docstring."""

LONGER = {
    "blender_addon/w2w/core/motion/motion.py",
    "blender_addon/w2w/ui/study/state.py",
    "blender_addon/w2w/api/rank.py: rank",
    "blender_addon/w2w/headless/commands/place.py: place",  # commands: a line or more an option
    "blender_addon/w2w/headless/commands/run.py: run",
    "blender_addon/w2w/web/serve.py: serve",
    "packages/studies/w2w_studies/commands/study_mixamo.py: mixamo",
}
"""Files and functions that are longer; each leaves the list as soon as it is not."""


@cache
def modules() -> dict[Path, ast.Module]:
    """All code but the tests'."""
    files = [file for folder in (*PACKAGES.values(), *OTHERS) for file in sorted(folder.rglob("*.py"))]
    return {file: ast.parse(file.read_text(encoding="utf-8")) for file in files}


def test_files_and_functions_are_short():
    found = {name for file, tree in modules().items() for name in too_long(file, tree)}
    assert not found - LONGER, f"divide by subject: at most {FILE} lines a file and {FUNCTION} a function"
    assert not LONGER - found, "these are short now: take them from the list"


def too_long(file: Path, tree: ast.Module) -> Iterator[str]:
    """Names of a file and of functions in it that have too many lines."""
    name = file.relative_to(ROOT).as_posix()
    if len(file.read_text(encoding="utf-8").splitlines()) > FILE:
        yield name
    for each in ast.walk(tree):
        if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef):
            docstring = each.body[0] if ast.get_docstring(each, clean=False) else None
            own = docstring.end_lineno - docstring.lineno + 1 if docstring else 0
            if each.end_lineno - each.lineno + 1 - own > FUNCTION:
                yield f"{name}: {each.name}"


def test_no_room_takes_a_private_name_of_another():
    found = [said for file, tree in modules().items() for said in private_names(file, tree)]
    assert not found, "give it a public name, or move what needs it"


def private_names(file: Path, tree: ast.Module) -> Iterator[str]:
    """Private names of other packages that a module imports, or takes from a module that it imports."""
    room, taken = room_of(file), {}
    for each in imports(tree):
        home = source_of(each, room)
        for alias in each.names:
            if is_private(alias.name) and home[:-1] != room and home != room:
                yield f"{file.relative_to(ROOT)}:{each.lineno} {alias.name}"
            taken[alias.asname or alias.name] = home
    for each in ast.walk(tree):
        if isinstance(each, ast.Attribute) and isinstance(each.value, ast.Name) and is_private(each.attr):
            home = taken.get(each.value.id, room)
            if home != room and is_module(home, each.value.id):
                yield f"{file.relative_to(ROOT)}:{each.lineno} {each.attr}"


def test_imports_inside_a_package_are_relative():
    found = [
        f"{file.relative_to(ROOT)}:{each.lineno}"
        for file, tree in modules().items()
        if (room := room_of(file))
        for each in imports(tree)
        if not each.level and (each.module or "").split(".")[0] == room[0]
    ]
    assert not found, "write from .module import name, or from ..room.module"


def imports(tree: ast.Module) -> Iterator[ast.ImportFrom]:
    """Every `from ... import` of a module, those in functions, too."""
    return (each for each in ast.walk(tree) if isinstance(each, ast.ImportFrom))


def room_of(file: Path) -> list[str]:
    """The package that a module is in, as parts of its name; empty for a program outside of packages."""
    for name, folder in PACKAGES.items():
        if file.is_relative_to(folder):
            return [name, *file.parent.relative_to(folder).parts]
    return []


def source_of(each: ast.ImportFrom, room: list[str]) -> list[str]:
    """The module that names are imported from, as parts of its name."""
    above = room[: len(room) + 1 - each.level] if each.level else []
    return [*above, *(each.module.split(".") if each.module else [])]


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def is_module(home: list[str], name: str) -> bool:
    """Whether a name imported from a package of ours is a module."""
    return home[0] in PACKAGES and (PACKAGES[home[0]].joinpath(*home[1:], name).with_suffix(".py")).exists()


PLANTED = {
    "from ..core.selection.answer import _others": "_others",
    "from ..core.selection import answer\nanswer._others": "_others",
    "def late():\n    from ..headless.runs import study\n    study._bake": "_bake",
}


@pytest.mark.parametrize(("code", "name"), PLANTED.items())
def test_a_private_name_that_is_taken_is_told(code, name):
    page = PACKAGES["w2w"] / "report" / "page.py"
    assert [said.split()[-1] for said in private_names(page, ast.parse(code))] == [name]


@pytest.mark.parametrize(
    "code", ["from .page import _own", "from ..core import files\nfiles.public", "import os\nos._exit(0)"]
)
def test_names_of_the_own_room_and_public_ones_may_be_taken(code):
    assert not [*private_names(PACKAGES["w2w"] / "report" / "worn.py", ast.parse(code))]


def test_a_long_function_is_told_by_its_name():
    code = (
        "def short():\n" + "    0\n" * 59 + 'def long():\n    """One.\n\n    Two.\n    """\n' + "    0\n" * 60
    )
    file = PACKAGES["w2w"] / "core" / "given.py"
    assert [*too_long(file, ast.parse(code))] == ["blender_addon/w2w/core/given.py: long"]
