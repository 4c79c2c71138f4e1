# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished study as a .blend file that opens complete in any Blender, with or without W2W.

For W2W's panel it holds the small files of the results folder, packed as a text: this record
is only data; nothing in it is ever run.
"""

import base64
import hashlib
import io
import json
import tempfile
import zlib
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar
from weakref import WeakKeyDictionary
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from ...core.files import DAMAGED, folder_beside, most_unpacked
from ...core.motion.motion import Motion
from ...core.patches.patches import PatchSet
from ...core.ranking.utility import UtilityMap
from ...core.study.clip_files import CLIP_LIST, WORK, signals_key
from ...core.study.results import UTILITY, StudyResults
from ...core.wording import restated
from .. import heatmap
from ..base.actions import set_scene_rate, show_action, write_action
from ..base.body import add_body
from ..base.module import bpy
from ..base.patches import patch_empties, place_patches

KEPT = 8
"""Unpacked results kept in memory."""

MOST_PACKED = 2**30
"""No patches or ranking of ours are npz files of more bytes."""

T = TypeVar("T", PatchSet, UtilityMap)

_unpacked: OrderedDict[str, Any] = OrderedDict()
_packed: WeakKeyDictionary[PatchSet | UtilityMap, tuple[str, str]] = WeakKeyDictionary()
"""Text and key of values that were packed."""


def pack(value: PatchSet | UtilityMap) -> tuple[str, str]:
    """Its file as text, ASCII and compressed, and a key that is equal for equal content."""
    if value not in _packed:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "value.npz"
            value.save(path)
            content = path.read_bytes()
        text, key = base64.b64encode(zlib.compress(content)).decode("ascii"), hashlib.sha256(content)
        _packed[value] = text, key.hexdigest()[:24]
        _keep(_packed[value][1], value)
    return _packed[value]


def unpack(key: str, text: Callable[[], str], load: Callable[[Any], T]) -> T:
    """The value of a key; its text is asked for only when it is not in memory.

    Raises
    ------
    ValueError
        If the text is damaged, or claims to unpack to far more than anything of ours.
    """
    if key not in _unpacked:
        stream = zlib.decompressobj()
        with restated("packed results are damaged", (zlib.error, ValueError)):
            packed = base64.b64decode(text())
            content = stream.decompress(packed, min(MOST_PACKED, most_unpacked(len(packed))))
            if not stream.eof:
                raise ValueError("it ends too early")
        _keep(key, load(io.BytesIO(content)))
    _unpacked.move_to_end(key)
    return _unpacked[key]


def _keep(key: str, value: PatchSet | UtilityMap) -> None:
    _unpacked[key] = value
    while len(_unpacked) > KEPT:
        _unpacked.popitem(last=False)


EMPTY_SIZE, CHOSEN_SIZE = 0.006, 0.018
"""Size of the empties, metres: small, so that they do not hide the heatmap, but for the chosen ones."""

RECORD = "W2W study"
"""Custom property of a body's mesh: the text that holds its study."""

FILES = ("summary.json", "config.json", CLIP_LIST, UTILITY, f"{WORK}/patches.npz")
"""Files of a results folder that the record holds."""

NAMES = "names.json"


def write_study(
    path: str | Path, study: StudyResults, motions: Iterable[Motion], chosen: Sequence[int]
) -> None:
    """Write a finished study to a .blend file, whole or not at all.

    It holds the body, its armature with an action a motion, an empty on each patch with its
    scores as custom properties, the chosen patches in a collection of their own, a colour
    attribute an activity and for the mean, and what W2W's panel shows when it opens the file. The
    file is built in a fresh Blender session, in a process of its own: whatever is open is closed.

    Parameters
    ----------
    motions : iterable of Motion
        The scene takes the rate of the first.
    chosen : sequence of int
        Chosen patches in order of choice.
    """
    bpy.ops.wm.read_homefile(use_factory_startup=True)
    bpy.data.batch_remove([*bpy.data.objects, *bpy.data.collections, *bpy.data.materials])  # not its window
    bpy.data.orphans_purge(do_recursive=True)
    bpy.context.scene.name = "W2W Study"
    body, utility = study.body(), study.utility
    objects = add_body(body, name="Body")
    heatmap.dress(objects.mesh, body)
    heatmap.add_heatmaps(
        objects.mesh, study.patches, utility.expected_f1, utility.activities, utility.expected_mean,
    )  # fmt: skip
    collections = _add_empties(objects.mesh, study, chosen)
    _add_record(objects.mesh, study, collections, _add_actions(objects.armature, motions))
    _set_up_view(objects.mesh, body.height)
    with folder_beside(Path(path)) as folder:  # no half-written file ever stands under its name
        temporary = Path(folder) / "study.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(temporary), compress=True, copy=True)
        temporary.replace(path)


def _add_empties(mesh: bpy.types.Object, study: StudyResults, chosen: Sequence[int]) -> tuple[str, str]:
    """Add an empty a patch; gives the names of the collections of all and of the chosen ones."""
    utility = study.utility
    placed = place_patches(mesh, study.patches, size=EMPTY_SIZE)
    empties = patch_empties(placed)
    for number, empty in enumerate(empties):
        empty[heatmap.MEAN] = float(utility.expected_mean[number])
        for activity, score in zip(utility.activities, utility.expected_f1[number], strict=True):
            name = f"{heatmap.MEAN}: {activity}".encode()[:63].decode(errors="ignore")
            empty[name] = float(score)
    collection = bpy.data.collections.new("Chosen patches")
    collection.color_tag = "COLOR_01"
    bpy.context.scene.collection.children.link(collection)
    for rank, number in enumerate(chosen, start=1):
        empty = empties[number]
        empty["order of choice"] = rank
        empty.empty_display_type = "SPHERE"
        empty.empty_display_size = CHOSEN_SIZE
        empty.show_name = empty.show_in_front = True
        collection.objects.link(empty)
        empty.select_set(True)  # names of selected objects are bright
    return placed.name, collection.name


def _add_actions(armature: bpy.types.Object, motions: Iterable[Motion]) -> dict[str, str]:
    """Write the motions at the first one's rate and show that one; gives the actions' names by clip."""
    scene = bpy.context.scene
    names: dict[str, str] = {}
    for motion in motions:
        if not names:
            set_scene_rate(motion.rate)
            scene.frame_start, scene.frame_end = 1, motion.n_frames
        labels = dict.fromkeys(part for part in (motion.activity, motion.subject, motion.clip) if part)
        action = write_action(armature, motion, " ".join(labels))
        if not names:
            show_action(armature, action)
        names[motion.clip] = action.name
    scene.frame_set(1)
    return names


def _add_record(
    mesh: bpy.types.Object, study: StudyResults, collections: tuple[str, str], actions: Mapping[str, str]
) -> None:
    """Put the record of a results folder into the open file, on a body's mesh."""
    packed = io.BytesIO()
    with ZipFile(packed, "w", ZIP_DEFLATED) as archive:
        for name in FILES:
            archive.writestr(ZipInfo(name), (study.out / name).read_bytes(), ZIP_DEFLATED)
        content = {"collections": collections, "actions": actions, "signals": keys_of(study)}
        archive.writestr(ZipInfo(NAMES), json.dumps(content), ZIP_DEFLATED)
    text = bpy.data.texts.new(RECORD)
    text.from_string(base64.encodebytes(packed.getvalue()).decode("ascii"))
    mesh[RECORD] = text


def _set_up_view(mesh: bpy.types.Object, height: float) -> None:
    """Show the heatmap and the whole body in every 3D view of the file's window."""
    bpy.context.view_layer.objects.active = mesh
    areas = [area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D"]
    for space in (area.spaces.active for area in areas):
        space.shading.type = "SOLID"
        space.shading.color_type = "VERTEX"
        space.shading.show_specular_highlight = False
        space.region_3d.view_perspective = "PERSP"
        space.region_3d.view_location = (0.0, 0.0, height / 2)
        space.region_3d.view_rotation = (0.7071, 0.7071, 0.0, 0.0)
        space.region_3d.view_distance = 1.8 * height


class SceneNames(NamedTuple):
    """Names in a run's .blend file."""

    collections: tuple[str, str]  # of all patches, and of the chosen ones
    actions: Mapping[str, str]  # by clip
    signals: Mapping[str, str]  # by clip, the key of `core.study.clip_files.signals_key`


def keys_of(study: StudyResults) -> dict[str, str]:
    """The key of each clip's stored signals."""
    return {clip.name: signals_key(study.out, clip.name) for clip in study.clips}


def has_record(mesh: bpy.types.Object) -> bool:
    """Whether a mesh has a record."""
    return isinstance(mesh.get(RECORD), bpy.types.Text)


def read_record(mesh: bpy.types.Object) -> tuple[StudyResults, SceneNames]:
    """The study that a record holds, without large files, and names in the file; ValueError if damaged."""
    faults = ValueError, AttributeError, RecursionError, OSError, *DAMAGED
    with restated(f"what the file says of '{mesh.name}' is damaged:", faults):
        packed = base64.b64decode(mesh[RECORD].as_string())
        with ZipFile(io.BytesIO(packed)) as archive, tempfile.TemporaryDirectory() as folder:
            size = sum(archive.getinfo(name).file_size for name in (*FILES, NAMES))
            if size > min(MOST_PACKED, most_unpacked(len(packed))):
                raise ValueError("it unpacks to too much")
            for name in FILES:  # and no other that the file may name
                archive.extract(name, folder)
            study = StudyResults.load(Path(folder))
            study.summary, study.entries  # noqa: B018 - kept, for the folder does not stay
            names = json.loads(archive.read(NAMES))
            placed, chosen = map(str, names["collections"])
            actions, signals = (
                {clip: str(name) for clip, name in names[part].items()} for part in ("actions", "signals")
            )
            return study, SceneNames((placed, chosen), actions, signals)


def remove_record(mesh: bpy.types.Object) -> None:
    """Take the record away: what it said is now the panel's."""
    text = mesh[RECORD]
    del mesh[RECORD]
    bpy.data.texts.remove(text)
