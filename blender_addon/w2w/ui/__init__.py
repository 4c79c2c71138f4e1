# SPDX-License-Identifier: GPL-3.0-or-later
"""The user interface: what registers with Blender, in the order in which it must."""

from importlib import import_module
from types import ModuleType
from typing import get_type_hints

import bpy

NAMES = (
    "jobs.preferences", "steps.body", "panels.rows", "panels.properties", "jobs.jobs", "jobs.windows",
    "steps.motions", "steps.import_dialog", "steps.bone_maps", "steps.patches", "steps.baking",
    "steps.choosing", "steps.run_all", "steps.examples", "panels.menus", "files.open_results",
    "files.save_results", "files.exports", "files.pictures", "files.film", "files.questions",
    "files.moving_patches", "panels.top", "panels.steps", "panels.character", "panels.wearing",
    "panels.sensor", "panels.results", "panels.placement", "viewport.framing", "viewport.overlay",
    "files.upkeep",
)  # fmt: skip

MODULES = tuple(import_module(f".{name}", __name__) for name in NAMES)
"""Modules with classes to register, in their order, and those that also have a `register` of their own."""

KINDS = (
    bpy.types.AddonPreferences, bpy.types.FileHandler, bpy.types.Menu, bpy.types.Operator, bpy.types.Panel,
    bpy.types.PropertyGroup, bpy.types.UIList,
)  # fmt: skip


NAMES_STAY = "W2W"
"""Context of W2W's names, in which Blender finds no translations: else half of them would be translated."""


def register() -> None:
    """Register every class, menu entry, tool and handler."""
    for module in MODULES:
        for cls in _classes(module):
            _keep_names(cls)
            bpy.utils.register_class(cls)
        if hasattr(module, "register"):
            module.register()


def unregister() -> None:
    """Take back what `register` did, in reverse order."""
    for module in reversed(MODULES):
        if hasattr(module, "unregister"):
            module.unregister()
        for cls in reversed(_classes(module)):
            bpy.utils.unregister_class(cls)


def _keep_names(cls: type) -> None:
    """Let the names of a class and of its properties be as they are in every language."""
    if issubclass(cls, (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu)):
        setattr(cls, "bl_translation_context", NAMES_STAY)  # noqa: B010 - its stub lacks it
    for base in cls.__mro__:
        if base.__module__.startswith(__name__):
            found = {name: kind for name, kind in get_type_hints(base).items() if hasattr(kind, "keywords")}
            for declared in found.values():
                declared.keywords["translation_context"] = NAMES_STAY
            base.__annotations__ = {**base.__annotations__, **found}


def _classes(module: ModuleType) -> list[type]:
    """Classes that a module defines for Blender, in the order in which it does."""
    found = [item for item in vars(module).values() if isinstance(item, type) and issubclass(item, KINDS)]
    return [cls for cls in found if cls.__module__ == module.__name__]
