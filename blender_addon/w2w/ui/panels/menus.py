# SPDX-License-Identifier: GPL-3.0-or-later
"""Menus: Add > Mesh, File > Import, dropped files, presets, the keymap."""

from pathlib import Path
from typing import Any

import bpy
from bl_operators.presets import AddPresetBase

from ...core.reading.formats import MOTION_SUFFIXES
from ..study.declared import SHOWN
from ..study.operators import OnDrop

PRESETS = Path(__file__).parent / "presets"
PRESET_FOLDER = "w2w/study"

PRESET_PROPERTIES = (
    "own_sensor_text", "sensor", "record", "recognise_by", "magnetic_dip", "window_s",
    *(name for name, each in SHOWN.items() if each.stage in ("signals", "ranking") and name != "seed"),
)  # fmt: skip
"""Properties of a study that a preset sets, in this order."""

KEYS: tuple[tuple[str, dict[str, Any], dict[str, str]], ...] = (
    (
        "wm.tool_set_by_id",
        {"type": "W", "value": "PRESS", "ctrl": True, "alt": True},
        {"name": "w2w.pick_tool"},
    ),
    ("w2w.click_body", {"type": "LEFTMOUSE", "value": "CLICK"}, {}),
    ("w2w.clear_pick", {"type": "ESC", "value": "PRESS"}, {}),
)
"""Keys in a 3D view: operators, events, properties."""

STEPS = (
    ("add_body", "load_body", "use_mesh", "open_results", "locate_results", "select_body", "reset_shape"),
    ("use_character", "forget_character"),
    ("try_examples", "import_motions", "import_folder", "use_scene_animation", "map_bones", "load_bone_map"),
    ("relabel_clips", "remove_clips"),
    ("preview_clip", "show_source"),
    ("place_patches", "remove_patches", "bake_patches", "export_patches"),
    ("add_placement", "load_placements", "remove_placement"),
    ("add_garment", "wear_garment", "take_off"),
    ("start_sensor", "load_sensor", "save_sensor"),
    ("run_all", "bake_signals", "rank_patches", "fit_range", "side_by_side", "clear_pick", "show_others"),
    ("wish_picked", "choose_sensors", "find_needs", "add_pilot"),
    ("export_presentation", "export_film", "export_table", "export_report", "export_signals", "save_results"),
)  # fmt: skip
"""Operators by the steps of the panel."""

_keymap_items: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


class W2W_MT_study(bpy.types.Menu):
    """Everything that can be done with a body, for Blender's search (F3), too."""

    bl_label = "Where to Wear"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"  # else files would not be asked for
        for step in STEPS:
            for name in step:
                layout.operator(f"w2w.{name}")
            layout.separator()


class W2W_MT_study_presets(bpy.types.Menu):
    """Presets of sensor and window."""

    bl_label = "Study Presets"
    preset_subdir = PRESET_FOLDER
    preset_operator = "script.execute_preset"

    def draw(self, context: bpy.types.Context) -> None:
        self.draw_preset(context)
        self.layout.separator()
        self.layout.operator("w2w.add_study_preset", text="New Preset", translate=False, icon="ADD")
        remove = self.layout.operator(
            "w2w.add_study_preset", text="Remove Last Used", translate=False, icon="REMOVE"
        )
        remove.remove_active = True

    draw_preset = bpy.types.Menu.draw_preset


class W2W_OT_add_study_preset(AddPresetBase, bpy.types.Operator):
    """Save sensor, rate, window and folds as a preset, or remove one"""

    bl_idname = "w2w.add_study_preset"
    bl_label = "Add Study Preset"
    preset_menu = "W2W_MT_study_presets"
    preset_subdir = PRESET_FOLDER
    preset_defines = ["study = bpy.context.scene.w2w.body.w2w"]
    preset_values = [f"study.{name}" for name in PRESET_PROPERTIES]


class W2W_FH_motions(OnDrop, bpy.types.FileHandler):
    """Motion files dropped on the 3D view go onto the body."""

    bl_label = "Motions for W2W"
    bl_import_operator = "w2w.import_motions"
    bl_file_extensions = ";".join(MOTION_SUFFIXES)


def _add_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.operator("w2w.add_body", text="W2W Body", translate=False, icon="OUTLINER_OB_ARMATURE")


def _object_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.menu(W2W_MT_study.__name__)


def _import_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.operator(
        "w2w.import_motions", text=f"Motions for W2W ({'/'.join(MOTION_SUFFIXES)})", translate=False
    )
    self.layout.operator("w2w.open_results", text="Results of W2W (summary.json)", translate=False)


def _export_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.operator("w2w.save_results", text="Results of W2W (folder)", translate=False)


MENUS = (
    (bpy.types.VIEW3D_MT_mesh_add, _add_menu),
    (bpy.types.VIEW3D_MT_object, _object_menu),
    (bpy.types.TOPBAR_MT_file_import, _import_menu),
    (bpy.types.TOPBAR_MT_file_export, _export_menu),
)
"""Menus of Blender's own, and what is added to each."""


def register() -> None:
    """Hang the menus into Blender's own."""
    for menu, draw in MENUS:
        menu.append(draw)
    bpy.utils.register_preset_path(str(PRESETS.parent))
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is not None:  # there is none without a window
        keymap = configuration.keymaps.new(name="3D View", space_type="VIEW_3D")
        for operator, event, properties in KEYS:
            item = keymap.keymap_items.new(operator, **event)
            for name, value in properties.items():
                setattr(item.properties, name, value)
            _keymap_items.append((keymap, item))


def unregister() -> None:
    """Take back what `register` did."""
    for keymap, item in _keymap_items:
        keymap.keymap_items.remove(item)
    _keymap_items.clear()
    bpy.utils.unregister_preset_path(str(PRESETS.parent))
    for menu, draw in MENUS:
        menu.remove(draw)
