# SPDX-License-Identifier: GPL-3.0-or-later
"""Export: map, table, signals and report of the panel's study, as Python and the command line write them."""

from functools import partial
from pathlib import Path

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ...core.files import write_text
from ...core.findings.summary import patch_table
from ...core.given import file_name
from ...core.imu.formats import FORMATS, HELD, write_recording
from ...core.library.library import unique_names
from ...core.selection.advice import redundancy_clusters
from ...core.selection.headline import doubted, mean_title
from ...core.study.results import StudyResults, stored_recording
from ..jobs.jobs import Steps, in_thread, on_body
from ..steps.baking import ranked_clips
from ..study import counting, operators, scores, signal_cache, state
from ..viewport.legend import legend
from ..viewport.overlay import picks
from .save_results import with_saved

SUFFIXES = {"npz": ".npz", "csv": ".csv", "xsens": ".txt", "x-io": ""}

PICKED = ("PICKED", "Picked Spot", "The spot that you look at; of two that are compared, both")
"""The item of a choice of patches."""


def heading(mesh: bpy.types.Object) -> tuple[str, str]:
    """Title and subtitle of the heatmap that is shown."""
    study, utility, patches = mesh.w2w, state.ranking_of(mesh), state.placed_patches(mesh)
    values = scores.shown_scores(study, utility)
    index, best = scores.view_index(study), int(values.argmax())
    if scores.minus_index(study) >= 0:
        name = legend(study, utility).name
        return name, f"Farthest above: {patches.names[best]} ({values[best]:+.2f})"
    title = mean_title(utility) if counting.is_as_ranked(study, utility) else "Activities that count (mean)"
    if not index and study.scores == "EXPECTED":
        allowed = state.constraints_of(study).terms(patches).allowed
        best = int(np.where(allowed, values, -1).argmax())
    if index:
        title = utility.activities[index - 1].replace("_", " ").capitalize()
    return title, doubted(utility, f"Best spot: {patches.names[best]} ({values[best]:.2f})")


@on_body
def table_steps(mesh: bpy.types.Object, path: Path) -> Steps:
    """Write utility.csv."""
    utility, patches = state.ranking_of(mesh), state.placed_patches(mesh)

    def write(_: object) -> None:
        clusters = redundancy_clusters(utility.predictions, len(utility.activities))
        write_text(path, patch_table(utility, patches, clusters))

    yield from in_thread(write, f"writing {path.name}", 0.0, 1.0)
    return f"Saved the table: {path}"


@on_body
def signal_steps(mesh: bpy.types.Object, folder: Path, chosen: list[int] | None, kind: str) -> Steps:
    """Write the signals of some patches, a file each, or of all patches, a file a clip."""
    if chosen == []:
        raise ValueError("Click a spot on the body first, with the tool Pick Spot")
    patches, clips = state.placed_patches(mesh), ranked_clips(mesh.w2w)
    names = unique_names([f"{clip.name}.npz" for clip in clips])
    ends: dict[int | None, str] = {None: ".npz"}
    if chosen is not None:
        ends = {patch: f"_{file_name(patches.names[patch])}{SUFFIXES[kind]}" for patch in chosen}
    files = [
        (folder / f"{name}{end}", patch, place, (clip.activity, clip.subject, name))
        for clip, name, place in zip(clips, names, signal_cache.places_of(clips), strict=True)
        for patch, end in ends.items()
    ]
    standing = [path.name for path, *_ in files if path.exists()]
    if standing:
        raise ValueError(f"{folder} already holds {standing[0]}: choose another folder")
    folder.mkdir(parents=True, exist_ok=True)

    def write(path: Path, patch: int | None, place: tuple[Path, str], labels: tuple, _: object) -> None:
        whole = stored_recording(*place).labelled(patches.names, *labels)
        if patch is None:
            whole.save(path)
        else:
            write_recording(path, whole.at([patch]), kind)

    for number, file in enumerate(files):
        work = partial(write, *file)
        yield from in_thread(work, file[0].name, number / len(files), (number + 1) / len(files))
    text = f"Saved {len(files)} files of signals in {folder}"
    recorded = state.config_of(mesh.w2w).further.record if chosen is not None else ()
    lacking = [name for name in recorded if name not in HELD[kind]]
    return f"{text}, without {' and '.join(lacking)}, which {kind} files do not hold" if lacking else text


@on_body
def report_steps(mesh: bpy.types.Object, path: Path) -> Steps:
    """Write the report."""

    def page(study: StudyResults) -> str:
        from ...report.page import report_page  # jinja2 is slow to import

        return report_page(study)

    write_text(path, (yield from with_saved(mesh, page, f"writing {path.name}")))
    return f"Saved the report: {path}"


class Export(operators.AsksForFile, operators.StartsJob, operators.OnRanking):
    """An export to a file by `write`; `usual` is the name offered for it."""

    filepath: StringProperty(name="File", description="File to write", subtype="FILE_PATH")
    filter_glob: StringProperty(options={"HIDDEN"})
    check_existing: BoolProperty(default=True, options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self.filter_glob = f"*{Path(self.usual).suffix}"
        self.filepath = self.filepath or self.usual
        return super().invoke(context, event)

    def steps(self, body: bpy.types.Object) -> Steps:
        return self.write(body, Path(bpy.path.ensure_ext(str(self.path()), Path(self.usual).suffix)))


class W2W_OT_export_table(Export, bpy.types.Operator):
    """Save the F1 of every spot and activity as utility.csv"""

    usual = "utility.csv"
    write = staticmethod(table_steps)


class W2W_OT_export_report(Export, bpy.types.Operator):
    """Save the report: one page for any browser, with the map in 3D, the choice and the tables"""

    usual = "report.html"
    write = staticmethod(report_steps)


class W2W_OT_export_signals(operators.AsksForFolder, operators.StartsJob, bpy.types.Operator):
    """Save what sensors would have recorded: of the spot looked at, or of all spots, a file a clip"""

    which: EnumProperty(
        name="Spots",
        description="Whose signals are saved",
        items=(PICKED, ("ALL", "All Spots", "All spots, in W2W's own npz files")),
    )
    kind: EnumProperty(
        name="Format",
        description="Kind of file for a picked spot",
        items=[(name, name, f"As w2w synth --format {name}") for name in FORMATS],
        default="csv",
    )

    missing = operators.needs(
        lambda body: state.patches_of(body) and ranked_clips(body.w2w),
        "Bake the signals first (page Details)",
    )

    def steps(self, body: bpy.types.Object) -> Steps:
        picked = [patch for patch in picks(bpy.context, body) if patch < len(state.placed_patches(body))]
        return signal_steps(body, self.path(), picked if self.which == "PICKED" else None, self.kind)


class W2W_MT_export(bpy.types.Menu):
    """What can be taken out of a study besides picture and film."""

    bl_label = "Export"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        layout.operator("w2w.export_table", text="Table (utility.csv)", translate=False, icon="SPREADSHEET")
        for which, text in (("PICKED", "Signals of Picked Spot"), ("ALL", "Signals of All Spots")):
            layout.operator("w2w.export_signals", text=text, translate=False, icon="GRAPH").which = which
        layout.operator("w2w.export_patches", text="Moving Spots (usd)", translate=False, icon="EMPTY_ARROWS")
        layout.operator("w2w.export_report", text="Report (html)", translate=False, icon="WORLD")
        layout.operator("w2w.save_results", text="Results Folder", translate=False, icon="FILE_FOLDER")
