# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Python module, which the rest of `scene` imports from here.

As Blender starts, its sound library runs each shared library in a folder `plugins` of the current directory,
so that is another one meanwhile.
"""

import sys
from collections.abc import Iterable
from contextlib import chdir
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from pathlib import Path


def import_from(folders: Iterable[str], name: str) -> None:
    """Import a package from the first of these folders that has it; nothing happens if none has."""
    spec = PathFinder.find_spec(name, [*folders])
    if spec is not None and spec.loader is not None:
        module = sys.modules[name] = module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]  # as `import` does, or the next import would find half a package
            raise


if "bpy" not in sys.modules:
    # a worker inherits the path of a process that has `bpy`, whose import puts Blender's scripts there: the
    # package `bpy` among them needs the module loaded first
    others = [folder for folder in sys.path if Path(folder).parts[-2:] != ("scripts", "modules")]
    with chdir(Path(__file__).parent):
        import_from(others, "bpy")
import bpy as bpy  # noqa: E402, I001
import bmesh as bmesh  # noqa: E402 - which `bpy` brings
