# SPDX-License-Identifier: GPL-3.0-or-later
"""Base classes of operators: their needs, the file they ask for, the job they start."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, StringProperty

from ..jobs import jobs
from .state import LINKED, current_body, is_ranked, missing_body, patches_of

if TYPE_CHECKING:
    from bpy.types import Operator as Mixin
else:
    Mixin = object


class NamedOperator(Mixin):
    """An operator named after its class: W2W_OT_add_body is w2w.add_body, with the default label Add Body."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        _, is_operator, name = cls.__name__.partition("W2W_OT_")
        if is_operator:
            cls.bl_idname = f"w2w.{name}"
            cls.bl_label = vars(cls).get("bl_label", name.replace("_", " ").title())


class WorkOperator(NamedOperator):
    """An operator whose `work` may return a sentence about what was done, and raises what went wrong."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            done = self.work(context, current_body(context))
        except (ValueError, OSError) as error:
            return jobs.show_error(self, str(error))
        return jobs.show_done(self, done) if done else {"FINISHED"}


class OnBody(WorkOperator):
    """An operator that works on a body which no job is changing."""

    adds_body = False
    """Whether it adds the body that it works on where there is none."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        body = current_body(context)
        if body is None and cls.adds_body:
            return jobs.can_start(cls, context)
        if body is None:
            cls.poll_message_set(missing_body(context.scene))
        if body is None or not jobs.can_start(cls, context):
            return False
        missing = LINKED if body.library is not None else cls.missing(context, body)
        cls.poll_message_set(missing)
        return not missing

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object, /) -> str:
        """What the operator needs besides the body, as a sentence, or ""."""
        return ""


def needs(what: Callable[[bpy.types.Object], object], text: str) -> Any:
    """A `missing` that says a text unless a function of the body finds what is needed."""
    return staticmethod(lambda _context, body: "" if what(body) else text)


class OnClips(OnBody):
    """An operator that works on the list of clips."""

    missing = needs(lambda body: len(body.w2w.clips), "Import motions first (page Clips)")


class OnPatches(OnBody):
    """An operator that needs patches."""

    missing = needs(patches_of, "Place spots first, or Run All")


class OnRanking(OnBody):
    """An operator that needs a ranking."""

    missing = needs(is_ranked, "Score the spots first, or Run All")


class AsksForFile(NamedOperator):
    """An operator that asks for a file first."""

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def path(self) -> Path:
        """The file that was chosen."""
        return Path(bpy.path.abspath(self.filepath))


class AsksForFolder(AsksForFile):
    """An operator that asks for a folder first."""

    directory: StringProperty(name="Folder", subtype="DIR_PATH", options={"SKIP_SAVE"})
    filter_folder: BoolProperty(default=True, options={"HIDDEN"})

    def path(self) -> Path:
        """The folder that was chosen."""
        return Path(bpy.path.abspath(self.directory))


class OnDrop:
    """A handler of files dropped on a 3D view."""

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        return context.area is not None and context.area.type == "VIEW_3D"


class StartsJob(OnBody):
    """An operator that, once it has asked for what it needs, starts a job named like it."""

    bl_options = {"REGISTER"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        return jobs.start(self, context, self.bl_label, self.steps(current_body(context)))


class JobOperator(StartsJob):
    """An operator that is a job named like it: in the background from a button, at once from a script."""

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return super().execute(context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        return jobs.run_now(self, self.bl_label, self.steps(current_body(context)))
