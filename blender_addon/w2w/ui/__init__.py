# SPDX-License-Identifier: GPL-3.0-or-later
"""The user interface: what registers with Blender, in the order in which it must."""

from __future__ import annotations

from types import ModuleType

import bpy

from . import (
    character,
    choosing,
    exports,
    garment_properties,
    garments,
    import_dialog,
    job_windows,
    jobs,
    menus,
    open_results,
    overlay,
    own_placement_panel,
    own_sensor_panel,
    panels,
    pick_tool,
    placement_panels,
    preferences,
    properties,
    result_panels,
    run_all,
    save_results,
    source_view,
    step1_body,
    step2_motions,
    step3_patches,
    step4_signals,
    step5_ranking,
    upkeep,
)

MODULES: tuple[ModuleType, ...] = (
    preferences,
    garment_properties,
    properties,
    jobs,
    job_windows,
    step1_body,
    step2_motions,
    import_dialog,
    source_view,
    step3_patches,
    step4_signals,
    step5_ranking,
    choosing,
    run_all,
    menus,
    open_results,
    save_results,
    exports,
    panels,
    character,
    own_placement_panel,
    own_sensor_panel,
    garments,
    result_panels,
    placement_panels,
    pick_tool,
    overlay,
    upkeep,
)
"""Modules with classes to register; those with a `register` of their own do it themselves."""


def register() -> None:
    """Register every class, menu entry, tool and handler."""
    for module in MODULES:
        if hasattr(module, "register"):
            module.register()
        else:
            for cls in module.CLASSES:
                bpy.utils.register_class(cls)


def unregister() -> None:
    """Take back what `register` did, in reverse order."""
    for module in reversed(MODULES):
        if hasattr(module, "unregister"):
            module.unregister()
        else:
            for cls in reversed(module.CLASSES):
                bpy.utils.unregister_class(cls)
