# SPDX-License-Identifier: GPL-3.0-or-later
"""The user interface: what registers with Blender, in the order in which it must."""

from types import ModuleType

import bpy

from .files import exports, open_results, save_results
from .jobs import jobs, preferences
from .jobs import windows as job_windows
from .panels import character, menus, properties, rows, wearing
from .panels import placement as placement_panels
from .panels import results as result_panels
from .panels import sensor as own_sensor_panel
from .panels import steps as panels
from .results import upkeep
from .steps import baking, bone_maps, choosing, import_dialog, run_all
from .steps import body as step1_body
from .steps import motions as step2_motions
from .steps import patches as step3_patches
from .viewport import overlay

MODULES: tuple[ModuleType, ...] = (
    preferences, step1_body, rows, properties, jobs, job_windows,
    step2_motions, import_dialog, bone_maps, step3_patches, baking, choosing, run_all, menus, open_results,
    save_results, exports, panels, character, wearing, own_sensor_panel,
    result_panels, placement_panels, overlay, upkeep,
)  # fmt: skip
"""Modules with classes to register, in their order, and those that also have a `register` of their own."""

KINDS = (
    bpy.types.AddonPreferences, bpy.types.FileHandler, bpy.types.Menu, bpy.types.Operator, bpy.types.Panel,
    bpy.types.PropertyGroup, bpy.types.UIList,
)  # fmt: skip


def register() -> None:
    """Register every class, menu entry, tool and handler."""
    for module in MODULES:
        for cls in _classes(module):
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


def _classes(module: ModuleType) -> list[type]:
    """Classes that a module defines for Blender, in the order in which it does."""
    found = [item for item in vars(module).values() if isinstance(item, type) and issubclass(item, KINDS)]
    return [cls for cls in found if cls.__module__ == module.__name__]
