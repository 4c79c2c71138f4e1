# SPDX-License-Identifier: GPL-3.0-or-later
"""The study of a body: its parts as core's types, and what a step still lacks."""

import hashlib
import json
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import bpy

from ...core.body.body import Body
from ...core.body.shapes import RANGES
from ...core.given import inside
from ...core.parameters import parameters_at
from ...core.patches.patches import PatchSet
from ...core.ranking.utility import UtilityMap, unavailable
from ...core.selection.constraints import Constraints
from ...core.study.clip_files import WORK
from ...core.study.config import StudyConfig
from ...core.windows.windows import WindowSpec
from ...core.wording import capital
from ...scene.base.body import body_of
from ...scene.base.patches import PATCH
from ...scene.files.study_file import unpack
from .counting import LEFT_OUT, Group, counted_in, is_reweighed
from .covers import parameters, wardrobe_text
from .declared import SHOWN, as_given, config_shown, property_of
from .sensors import OWN, further_of, own_sensor

AS_SHOWN = 1e-5
"""Largest error of single precision in a position, metres, or a weight."""

_depth = 0

GLANCE = 0.05
_glances: dict[tuple[str, str], tuple[float, str]] = {}

_unreadable: set[str] = set()
"""Keys of rankings that could not be read: panels ask again at every drawing."""


@contextmanager
def without_updates() -> Iterator[None]:
    """Inside, `is_silent` holds and update functions do nothing."""
    global _depth
    _depth += 1
    try:
        yield
    finally:
        _depth -= 1


def is_silent() -> bool:
    """Whether updates shall do nothing."""
    return _depth > 0


BAKED, STALE, IMPORTED, FAILED = "baked", "stale", "imported", "failed"
"""States of a clip."""

LINKED = "This body is linked from another file: append it instead, or make it local (Object > Relations)"

ONLY, FORBID, MUST, COST = "ONLY", "FORBID", "MUST", "COST"
"""Kinds of wishes."""


def current_body(context: bpy.types.Context) -> bpy.types.Object | None:
    """The body that the panel works on, or None: it may have been deleted, or be of another scene."""
    body = context.scene.w2w.body
    return body if body is not None and context.scene.objects.get(body.name) is body else None


def polled_body(context: bpy.types.Context) -> bpy.types.Object:
    """The body of a panel or an operator whose `poll` saw one."""
    return context.scene.w2w.body


def bodies(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """All bodies of a scene."""
    return [item for item in scene.objects if item.type == "MESH" and item.w2w.is_body]


def body_of_object(item: bpy.types.Object | None) -> bpy.types.Object | None:
    """The body that an object belongs to: itself, the parent of a patch, or the armature's mesh."""
    if item is None:
        return None
    if item.type == "MESH" and item.w2w.is_body:
        return item
    if PATCH in item and item.parent is not None and item.parent.w2w.is_body:
        return item.parent
    if item.type == "ARMATURE":
        return next((child for child in item.children if child.type == "MESH" and child.w2w.is_body), None)
    return None


def config_of(study: Group) -> StudyConfig:
    """The study's `StudyConfig`; what the panel does not show is as in the opened run."""
    run = run_of(study)
    background, weights = counted_in(study, run)
    return replace(
        _config_of_signals(study, run),
        background=background,
        weights=weights,
        placements=own_placed(study),
        constraints=constraints_of(study),
    )


def _config_of_signals(study: Group, run: StudyConfig) -> StudyConfig:
    """The parameters without those that only rank by the activities' names and choose."""
    length = as_given(study.window_s, run.windows.length_s)
    sensor: dict[str, Any] = {"sensor": study.sensor}
    if study.sensor == OWN:
        sensor = {"sensor": own_sensor(study).name, "own_sensor": own_sensor(study)}
    worn = parameters(study, run)
    return replace(
        config_shown(study, run),
        **sensor,
        further=further_of(study, run.further, any(worn.values())),
        windows=run.windows if length == run.windows.length_s else WindowSpec.of_length(length),
        **worn,
    )


def run_of(study: Group) -> StudyConfig:
    """The parameters of the run that a study was opened from, or the defaults."""
    return _run(study.parameters)


@lru_cache(maxsize=8)  # panels ask at every drawing
def _run(parameters: str) -> StudyConfig:
    return StudyConfig.from_dict(json.loads(parameters or "{}"))


def constraints_of(study: Group) -> Constraints:
    """The study's wishes as `Constraints`; those without a place yet are left out."""
    found: dict[str, list] = {ONLY: [], FORBID: [], MUST: [], COST: []}
    for wish in study.wishes:
        for words in (part.strip() for part in wish.place.split(",")):
            if words:
                cost = as_given(wish.cost, float(wish.given or "nan"))
                found[wish.kind].append((words, cost) if wish.kind == COST else words)
    return Constraints(*(tuple(wishes) for wishes in found.values()))


def own_placed(study: Group) -> tuple[tuple[str, int], ...]:
    """Name and vertex of the user's placements that are in the patch set."""
    held = json.loads(study.own_placed) if study.own_placed else {"placements": []}
    return tuple((name, vertex) for name, vertex in held["placements"])


def sampled_patches(study: Group, total: int) -> int:
    """Number of sampled patches; the others are the user's placements."""
    return json.loads(study.own_placed)["sampled"] if study.own_placed else total


def placing_of(study: Group) -> str:
    """The settings that patches are placed by."""
    return f"{study.patch_count} {study.patch_seed}"


def is_placed_otherwise(study: Group) -> bool:
    """Whether the patches were placed by other settings than those of now; False if that is not known."""
    return study.placed_as not in ("", placing_of(study))


def keep_own_placed(study: Group, placements: Iterable[tuple[str, object]], sampled: int) -> None:
    """Note which of the user's placements are in the patch set and how many patches were sampled."""
    held = [[name, vertex] for name, vertex in placements]
    study.own_placed = json.dumps({"sampled": sampled, "placements": held}) if held else ""


def advice_settings(study: Group) -> str:
    """A hash of everything that a choice of sensors depends on."""
    config = config_of(study)
    ticks = [activity.name for activity in study.activities if activity.part == LEFT_OUT]
    wishes = [each.of(config) for each in parameters_at("choice", StudyConfig).values()]
    parts = [study.ranked_as, study.utility_key, *wishes, ticks]
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:24]


def patches_of(body: bpy.types.Object) -> PatchSet | None:
    """The patches placed on a body; None if there are none, or they belong to the body it was copied from."""
    study = body.w2w
    collection = study.patch_collection
    if not study.patches_key or collection is None:
        return None
    first = next(iter(collection.objects), None)
    is_own = first is not None and first.parent is body
    return unpack(study.patches_key, lambda: study.patches_text, PatchSet.load) if is_own else None


def placed_patches(body: bpy.types.Object) -> PatchSet:
    """The patches placed on a body; a ValueError if there are none."""
    patches = patches_of(body)
    if patches is None:
        raise ValueError("Place spots first, or Run All")
    return patches


def ranking_of(body: bpy.types.Object) -> UtilityMap:
    """A body's ranking; a ValueError if it has none."""
    utility = utility_of(body.w2w)
    if utility is None:
        raise ValueError("Score the spots first, or Run All")
    return utility


def body_as_run(mesh: bpy.types.Object) -> Body:
    """A study's body, from the opened run if it is the same: a mesh keeps single precision only."""
    shown = body_of(mesh)
    if not mesh.w2w.results_folder:
        return shown
    try:
        run = Body.load(inside(Path(mesh.w2w.results_folder), f"{WORK}/body.npz"))
    except (OSError, ValueError):
        return shown
    return run if run.is_near(shown, AS_SHOWN) else shown


def utility_of(study: Group) -> UtilityMap | None:
    """The ranking, or None if there is none that can be read."""
    key = study.utility_key
    if not key or key in _unreadable:
        return None
    try:
        return unpack(key, lambda: study.utility_text, UtilityMap.load)
    except ValueError:
        _unreadable.add(key)
        return None


def is_ranked(body: bpy.types.Object) -> bool:
    """Whether a body has patches and a ranking of them."""
    return utility_of(body.w2w) is not None and patches_of(body) is not None


def is_up_to_date(study: Group) -> bool:
    """Whether there is a ranking, of the clips, settings and weights as they are now."""
    utility = utility_of(study)
    if utility is None or study.ranked_as != rank_settings(study):
        return False
    return not is_reweighed(study, utility)


def outdated_at_a_glance(body: bpy.types.Object) -> str:
    """What `outdated` said at most `GLANCE` seconds ago: one drawing asks a dozen times."""
    key, now = (body.name_full, body.w2w.ranked_as), time.monotonic()
    if key not in _glances or now - _glances[key][0] > GLANCE:
        _glances.clear()
        _glances[key] = now, outdated(body)
    return _glances[key][1]


def outdated(body: bpy.types.Object) -> str:
    """Why a body's ranking is not of its study as it is now, as a sentence, or ""."""
    study = body.w2w
    if utility_of(study) is None or body.library is not None:
        return ""
    if missing := missing_for_patches(body):
        return missing
    if is_placed_otherwise(study):
        return "The number of spots or their seed has changed since they were placed"
    settings = bake_settings(study)
    if study.ranked_as == rank_settings(study):
        return ""
    if any(state_of(clip, settings) == STALE for clip in study.clips):
        return "The body, the spots or the sensor have changed since the signals were baked"
    return "Clips, labels or settings have changed since the ranking"


def unreadable_ranking(study: Group) -> str:
    """A sentence if the file holds a ranking that this version cannot read, else ""."""
    is_unreadable = study.utility_key and utility_of(study) is None
    return "The ranking in this file cannot be read: score the spots again" if is_unreadable else ""


def bake_settings(study: Group) -> str:
    """Everything that signals depend on besides body and motion: the patches' key, and a hash of the rest."""
    counting = [name for name in RANGES if getattr(study.shape, f"set_{name}", True)]
    shape = tuple((name, getattr(study.shape, name)) for name in counting)
    config = _config_of_signals(study, run_of(study))
    return f"{study.patches_key} {_digest(config, shape, wardrobe_text(study))}"


@lru_cache(maxsize=8)  # panels ask at every drawing
def _digest(config: StudyConfig, *others: object) -> str:
    return hashlib.sha256(repr((config.signal_parameters(), others)).encode()).hexdigest()[:24]


def kept_patches(study: Group, clip: Group) -> int:
    """Number of leading patches that already have up-to-date signals (patches were appended since)."""
    before, _, count = study.patches_before.partition(" ")
    key, _, rest = bake_settings(study).partition(" ")
    return int(count) if before and key != before and clip.baked_as == f"{before} {rest}" else 0


def rank_settings(study: Group) -> str:
    """A hash of everything that a ranking depends on."""
    chosen = [property_of(name) for name, each in SHOWN.items() if each.stage == "ranking"]
    parts = [bake_settings(study), *(str(getattr(study, name)) for name in chosen)]
    parts += [f"{clip.signals} {clip.activity} {clip.subject}" for clip in study.clips if not clip.problem]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:24]


def state_of(clip: Group, settings: str) -> str:
    """Whether a clip is baked, as one of BAKED, STALE, IMPORTED and FAILED; `settings` of `bake_settings`."""
    if clip.problem or clip.action is None:
        return FAILED
    if not clip.signals:
        return IMPORTED
    return BAKED if clip.baked_as == settings else STALE


def usable(study: Group) -> list[Group]:
    """Clips with a motion."""
    return [clip for clip in study.clips if clip.action is not None and not clip.problem]


def baked(study: Group) -> list[Group]:
    """Clips with up-to-date signals."""
    settings = bake_settings(study)
    return [clip for clip in study.clips if state_of(clip, settings) == BAKED]


def selected(study: Group) -> list[Group]:
    """The ticked clips, or the active one if none is ticked."""
    ticked = [clip for clip in study.clips if clip.selected]
    return ticked or [clip for index, clip in enumerate(study.clips) if index == study.clip_index]


def playing_clip(body: bpy.types.Object) -> Group | None:
    """The clip whose action the body's armature plays."""
    armature = next((m.object for m in body.modifiers if m.type == "ARMATURE" and m.object), None)
    data = armature.animation_data if armature is not None else None
    if data is None or data.action is None:
        return None
    return next((clip for clip in body.w2w.clips if clip.action == data.action), None)


def missing_body(scene: bpy.types.Scene) -> str:
    """Why there is no body to work on: one that is linked as an instance of its collection is no object."""
    instances = (item.instance_collection for item in scene.objects if item.instance_collection)
    linked = (item for home in instances for item in home.all_objects)
    is_linked = any(item.type == "MESH" and item.w2w.is_body for item in linked)
    return LINKED if is_linked else "Add a body first"


def missing_for_patches(body: bpy.types.Object | None) -> str:
    """What prevents placing patches, as a sentence, or ""."""
    if body is None:
        return "Add a body first"
    if body.library is not None:
        return LINKED
    has_bones = any(part.type == "ARMATURE" and part.object for part in body.modifiers)
    return "" if has_bones else "The body has lost its armature: undo that (Ctrl Z), or add a body"


def missing_for_bake(body: bpy.types.Object | None) -> str:
    """What prevents baking signals, or ""."""
    if body is not None and not usable(body.w2w):
        return "Import motions first (page Clips)"
    if body is not None and patches_of(body) is None:
        return "Place spots first, or Run All"
    return missing_for_patches(body)


def missing_for_rank(body: bpy.types.Object | None) -> str:
    """What prevents ranking, or ""."""
    missing = missing_for_any_rank(body)
    return missing if body is None or missing else classifier_problem(body.w2w)


def missing_for_any_rank(body: bpy.types.Object | None) -> str:
    """What prevents ranking with any classifier, or ""."""
    missing = missing_for_bake(body)
    if body is None or missing:
        return missing
    clips = baked(body.w2w)
    return labels_problem(clips) if clips else "Bake the signals first (page Details)"


def labels_problem(clips: Sequence[Group]) -> str:
    """Why clips cannot be ranked by their labels, or ""."""
    labelled = Counter(clip.activity for clip in clips if clip.activity.strip())
    if sum(count > 1 for count in labelled.values()) < 2:
        if labelled.total() < len(clips):
            return "Give the clips activities (page Clips): two with two clips each are needed"
        return "Two activities with two clips each are needed"
    return ""


def classifier_problem(study: Group) -> str:
    """Why the chosen classifier cannot work here, or ""."""
    return capital(unavailable(study.classifier))
