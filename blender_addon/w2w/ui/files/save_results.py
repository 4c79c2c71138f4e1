# SPDX-License-Identifier: GPL-3.0-or-later
"""Save Results: the panel's study as a results folder, which the command line and Python read."""

import tempfile
from collections.abc import Callable, Generator
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import bpy

from ...core.findings.advice_content import needs_on
from ...core.findings.new_folder import check_new, write_folder
from ...core.library.library import Clip, Library, unique_names
from ...core.motion.motion import Motion
from ...core.study.clip_files import signals_key
from ...core.study.results import ClipResult, Study, StudyResults
from ...scene.base.actions import read_action
from ...scene.base.body import armature_of
from ..jobs.jobs import Step, Steps, in_thread, on_body, part
from ..steps.choosing import advised_steps, counted_clips
from ..study import counting, covers, lists, operators, state

T = TypeVar("T")


class W2W_OT_save_results(
    operators.AsksForFolder, operators.StartsJob, operators.OnRanking, bpy.types.Operator
):
    """Save the study as a results folder, as w2w run leaves one, in a new or empty folder"""

    def steps(self, body: bpy.types.Object) -> Steps:
        return save_steps(body, self.path(), stay=True)


@on_body
def save_steps(mesh: bpy.types.Object, folder: Path, stay: bool = False) -> Steps:
    """Read the study from the scene, clip by clip, then write a folder; `stay`: the study goes on in it."""
    study = mesh.w2w
    if study.ranked_as != state.rank_settings(study):
        raise ValueError("Clips or settings have changed since the ranking: rank again first (page Details)")
    check_new(folder)
    left_out, reweighed = set(counting.left_out(study)), counting.is_reweighed(study, state.ranking_of(mesh))
    sampled = state.sampled_patches(study, len(state.placed_patches(mesh)))
    config = replace(state.config_of(study), patches=sampled)
    found, advice = yield from part(advised_steps(mesh, config), 0.0, 0.6)
    clips, armature = counted_clips(study), armature_of(mesh)
    names = unique_names([f"{clip.name}.npz" for clip in clips])
    motions: list[Motion | None] = []
    for number, (clip, name) in enumerate(zip(clips, names, strict=True)):
        yield Step(0.6 + 0.2 * number / len(clips), clip.name)
        try:
            motions.append(read_action(armature, clip.action).labelled(clip.activity, clip.subject, name))
        except ValueError:  # its action moves the body in ways that no motion file tells
            motions.append(None)
    over = yield from part(covers.covers_steps(mesh, found.patches), 0.8, 0.8)
    saved = tuple(map(_saved, clips, names))
    skipped = [(clip.file or clip.name, clip.problem) for clip in study.clips if clip.problem]
    dropped = [(clip.name, clip.activity) for clip in study.clips if clip.activity in left_out]
    skipped += [(name, f"{activity} is left out") for name, activity in dropped]
    library = Library(Path(), tuple(clip.clip for clip in saved), "the panel in Blender", tuple(skipped))
    kept = {} if left_out or reweighed else lists.advice_of(study) or {}
    more = needs_on(kept.get("cards") or []), kept.get("pilot")
    finished = Study(library, config, found.body(), saved, found.renamed(names), advice, *more)

    def write(progress: Callable[[float], None]) -> list[str]:
        write_folder(folder, finished, motions, over, progress)
        return [signals_key(folder, name) for name in names]

    keys = yield from in_thread(write, f"writing {folder.name}", 0.8, 1.0)
    if stay and len(clips) == sum(bool(clip.signals) for clip in study.clips):
        # the study goes on in the folder; ranking and choice are as fresh as before
        advised = study.advised_as == state.advice_settings(study)
        study.results_folder = str(folder.resolve())
        for clip, key, name in zip(clips, keys, names, strict=True):
            clip.signals, clip.stored_as = key, name
        study.ranked_as = state.rank_settings(study)
        if advised:
            study.advised_as = state.advice_settings(study)
    text = f"Saved {len(clips)} clips and their ranking in {folder}"
    if left_out:
        return f"{text}, ranked anew without {', '.join(sorted(left_out))}"
    return f"{text}, ranked anew by the new weights" if reweighed else text


def with_saved(
    mesh: bpy.types.Object, work: Callable[[StudyResults], T], text: str
) -> Generator[Step, None, T]:
    """Save the study for a while, and do work on what was saved in a thread."""
    with tempfile.TemporaryDirectory(prefix="w2w_saved_") as temporary:
        folder = Path(temporary) / "results"
        yield from part(save_steps(mesh, folder), 0.0, 0.6)
        return (yield from in_thread(lambda _: work(StudyResults.load(folder)), text, 0.6, 1.0))


def _saved(clip: bpy.types.PropertyGroup, name: str) -> ClipResult:
    """A clip as it is in the scene, under a name for its files."""
    file = clip.file if clip.file and not Path(clip.file).is_absolute() else name
    return ClipResult(
        Clip(Path(file), file, name, clip.activity, clip.subject, clip.motion_key),
        "",
        {"take": "", "frames": clip.n_frames} | lists.facts_of(clip) | {"file": file},
        clip.source_sha256,
    )  # fmt: skip
