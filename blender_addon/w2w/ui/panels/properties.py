# SPDX-License-Identifier: GPL-3.0-or-later
"""A study as properties of its body's mesh, saved with the file."""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ...core.imu.presets import PRESETS
from ...core.patches.body_parts import PRODUCTS
from ...core.ranking.utility import CLASSIFIERS
from ...core.wording import capital
from ...scene.base.patches import EMPTY_SIZE
from ..jobs.jobs import is_there
from ..steps.body import W2W_PG_shape
from ..study import sensors, state
from ..study.declared import declared, properties
from ..study.pages import PAGES
from ..study.scores import EXPECTED, NOTHING, ON_THESE, beside_of, view_items
from . import rows

COLOUR_MAPS = (
    ("viridis", "Viridis", "Blue to yellow, even in lightness; safe for colour-blind eyes"),
    ("cividis", "Cividis", "Blue to yellow; looks the same to colour-blind eyes"),
    ("magma", "Magma", "Black to pale yellow, even in lightness"),
    ("batlow", "Batlow", "Dark blue to pink, even in lightness; safe for colour-blind eyes"),
)

SCORES = (
    (EXPECTED, "Expected F1", "What other clips would show, as far as these tell; the table goes by it"),
    (ON_THESE, "F1 on These Clips", "What came out on these very clips, their noise included"),
)

SENSOR_NAMES = {
    "ideal": "Ideal (no errors)", "phone": "Smartphone", "watch": "Smartwatch",
    "xsens mtw awinda": "Xsens MTw Awinda", "paper": "Errors of the Paper",
}  # fmt: skip

SPELLED = {name: name.upper() for name in PRESETS} | SENSOR_NAMES
SENSORS = [
    *((name, SPELLED[name], f"Signals as of {name}") for name in PRESETS),
    (sensors.OWN, "Own Part", "A part of your own: its figures are under Sensor and Bands"),
]

CLASSIFIER_NAMES = {
    "ridge": ("Ridge", "Linear, trained on all spots at once: seconds"),
    "trees": ("Extra Trees", "A forest a spot, for reference: minutes to hours"),
    "multi3net": (
        "Multi3Net",
        "A small neural network a spot, all trained together: an hour; needs PyTorch",
    ),
}
CLASSIFIER_ITEMS = [(name, *CLASSIFIER_NAMES.get(name, (name.title(), name))) for name in CLASSIFIERS]

FIRST_LIMIT = 3
"""Most sensors, when a limit is switched on."""


HABITS = [(name, capital(name), "") for name in PRODUCTS]
"""Products that people may wear anyway."""

ENDS = {"min": 0, "max": 1, "update": rows.repaint}
"""Arguments of both ends of the colour range."""

_menus: dict[str, list[tuple[str, str, str, int]]] = {}
"""Items of dynamic menus: Blender keeps no reference to their strings."""


def _views(self: W2W_PG_study, _context: bpy.types.Context) -> list[tuple[str, str, str, int]]:
    _menus["view"] = view_items(self)
    return _menus["view"]


def _minuses(self: W2W_PG_study, _context: bpy.types.Context) -> list[tuple[str, str, str, int]]:
    _menus["minus"] = [(NOTHING, "Nothing", "Show the heatmap itself", 0)]
    for key, name, _, number in view_items(self):
        _menus["minus"].append((key, name, f"Show how far F1 is above that for '{name}'", number + 1))
    return _menus["minus"]


def _views_beside(self: W2W_PG_study, _context: bpy.types.Context) -> list[tuple[str, str, str, int]]:
    _menus["beside"] = view_items(beside_of(self) or self)
    return _menus["beside"]


def _is_limited(study: W2W_PG_study) -> bool:
    return study.max_places > 0


def _limit(study: W2W_PG_study, limited: bool) -> None:
    study.max_places = FIRST_LIMIT if limited else 0


def _is_body(_self: bpy.types.PropertyGroup, item: bpy.types.Object) -> bool:
    return item.type == "MESH" and item.w2w.is_body


def _is_other(self: W2W_PG_study, item: bpy.types.Object) -> bool:
    return _is_body(self, item) and item != self.id_data and is_there(item) and state.is_ranked(item)


class KeptTexts:
    """Internal texts of a study: packed contents, keys, and the settings they were made with."""

    __annotations__ = {
        name: StringProperty(options={"HIDDEN"})
        for name in (
            "results_folder",  # that the study was opened from or saved in: its signals are there
            "results_near", "parameters", "utility_text", "utility_key", "ranked_as", "own_placed",
            "answer_text", "compared_text", "advice_text", "advised_as", "patches_text", "patches_key",
            "placed_as",  # number and seed that patches were placed by
            "patches_before",  # key and number of patches that only got more
        )
    }  # fmt: skip


class DeclaredProperties:
    """Parameters that are one property each, with what Blender is to know besides their declaration."""

    __annotations__ = properties(
        rate={"precision": 0, "step": 1000},
        band={"precision": 1},
        root_band={"precision": 1},
        classifier={"items": CLASSIFIER_ITEMS},
        target={"precision": 2, "subtype": "FACTOR", "update": rows.choose_patches},
        every_activity={"precision": 2, "subtype": "FACTOR", "update": rows.choose_patches},
        max_places={"soft_max": 12, "update": rows.choose_patches},
        habit={"items": HABITS, "update": rows.choose_patches},
    )


class W2W_PG_study(sensors.SensorProperties, DeclaredProperties, KeptTexts, bpy.types.PropertyGroup):
    """A study: everything W2W knows about one body."""

    is_body: BoolProperty(name="Is a Body", description="This mesh is the body of a study")
    has_shape: BoolProperty(name="Has a Shape", description="W2W's own body, whose shape can be changed")
    shape: PointerProperty(type=W2W_PG_shape, name="Shape")
    show_armature: BoolProperty(
        name="Show Armature", description="Show the body's bones", default=False, update=rows.show_armature
    )

    clips: CollectionProperty(type=rows.W2W_PG_clip)
    clip_index: IntProperty(name="Active Clip", description="The clip that buttons apply to")

    covers: CollectionProperty(type=rows.W2W_PG_cover)
    character: PointerProperty(type=bpy.types.Object)  # armature of what else shows map and sensors
    character_meshes: CollectionProperty(type=rows.W2W_PG_character_mesh)
    marks: PointerProperty(type=bpy.types.Collection, name="Sensors on the Character")
    fit: StringProperty(name="Fit", description="How well the character lies on the body")

    patch_collection: PointerProperty(type=bpy.types.Collection, name="Spots")
    chosen_collection: PointerProperty(type=bpy.types.Collection, name="Sensor Places")
    patch_seed: IntProperty(name="Seed", description="Chooses the spot that spreading starts from", min=0)
    patch_size: FloatProperty(
        name="Size",
        description="Length of the spots' axes",
        default=EMPTY_SIZE, min=0.001, max=0.1, unit="LENGTH", update=rows.resize_patches,
    )  # fmt: skip
    show_patches: BoolProperty(
        name="Show Spots", description="Show all spots", default=True, update=rows.show_patches
    )

    sensor: EnumProperty(
        **declared("sensor", description="The part whose noise, bias and range the signals get"),
        items=SENSORS,
    )
    window_s: FloatProperty(**declared("window", unit="TIME_ABSOLUTE"), precision=1)
    cautions_text: StringProperty(name="Cautions", description="What speaks against the answer")
    activities: CollectionProperty(type=rows.W2W_PG_activity)
    activity_index: IntProperty(
        name="Active Activity",
        description="The activity whose heatmap is shown",
        default=-1,
        update=rows.view_activity,
    )
    view: EnumProperty(
        name="Heatmap", description="What the colours of the body show", items=_views, update=rows.show_view
    )
    minus: EnumProperty(
        name="Minus",
        description="Show the difference to another heatmap: where this one's F1 is higher, and where lower",
        items=_minuses,
        update=rows.repaint,
    )
    scores: EnumProperty(
        name="Scores", description="Which scores the heatmaps show", items=SCORES, update=rows.repaint
    )
    colour_map: EnumProperty(
        name="Colours", description="Colour map of the heatmaps", items=COLOUR_MAPS, update=rows.repaint
    )
    beside: PointerProperty(type=bpy.types.Object)  # the copy that shows the second map
    beside_view: EnumProperty(
        name="Beside", description="The second map", items=_views_beside, update=rows.repaint
    )
    beside_body: PointerProperty(
        type=bpy.types.Object,
        name="Of Body",
        description="Body whose map is shown next to this one, such as another run's; by default this body",
        poll=_is_other,
        update=rows.repaint,
    )
    fix_range: BoolProperty(
        name="Same Range for All",
        description="Give all heatmaps the same colours for the same F1, so that activities can be compared",
        update=rows.fix_range,
    )
    range_low: FloatProperty(name="Low", description="F1 at the low end of the colours", **ENDS)
    range_high: FloatProperty(
        name="High", description="F1 at the high end of the colours", default=1.0, **ENDS
    )

    compare: StringProperty(
        name="Compare",
        description="Products or places whose F1 is shown, separated by commas: ring, necklace, left wrist",
        update=rows.compare_places,
    )
    limit_places: BoolProperty(
        name="Limit", description="Limit the number of sensors", get=_is_limited, set=_limit
    )
    own: CollectionProperty(type=rows.W2W_PG_own)
    own_index: IntProperty(
        name="Active Placement",
        description="The placement of yours that is looked at",
        update=rows.look_at_own,
    )
    wishes: CollectionProperty(type=rows.W2W_PG_wish)
    chosen: CollectionProperty(type=rows.W2W_PG_place)
    worn: CollectionProperty(type=rows.W2W_PG_place)
    regions: CollectionProperty(type=rows.W2W_PG_place)

    picked: IntProperty(name="Picked Spot", description="Spot looked at; -1 is none", default=-1)
    compared: IntProperty(name="Compared Spot", description="Spot compared with it; -1 is none", default=-1)
    picked_vertex: IntProperty(options={"HIDDEN"}, default=-1)


class W2W_PG_scene(bpy.types.PropertyGroup):
    """Settings of the panel in a scene."""

    body: PointerProperty(
        type=bpy.types.Object,
        name="Body",
        description="The body that the panel works on",
        poll=_is_body,
        update=rows.redraw,
    )
    show_overlay: BoolProperty(
        name="Show Overlay",
        description="Draw the picked spot and the colour bar in the 3D viewport",
        default=True,
        update=rows.redraw,
    )


def register() -> None:
    """Hang the groups on objects and scenes."""
    bpy.types.Object.w2w = PointerProperty(type=W2W_PG_study)
    bpy.types.Scene.w2w = PointerProperty(type=W2W_PG_scene)
    bpy.types.WindowManager.w2w_page = EnumProperty(
        name="Page", description="What the tab W2W shows", items=PAGES, options={"SKIP_SAVE"}
    )


def unregister() -> None:
    """Take back what `register` did."""
    del bpy.types.WindowManager.w2w_page
    del bpy.types.Scene.w2w
    del bpy.types.Object.w2w
