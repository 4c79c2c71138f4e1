# SPDX-License-Identifier: GPL-3.0-or-later
"""A job in Blender's windows: a timer drives it, input waits, every status bar shows how far it is."""

import time

import bpy

from ...core.wording import harmless
from . import jobs
from .jobs import Message, advance, show_error, views

TICK, BUDGET = 0.01, 0.03
"""Seconds between two slices of work, and of a slice."""

SHOWN_EVERY, DRAWING = 0.2, 0.2
"""Least seconds between two redraws that show how far a job is, and the largest share of its time that they
take: the window stands still meanwhile, and long where no graphics card draws it."""

PASSED_ON = {
    "MOUSEMOVE", "INBETWEEN_MOUSEMOVE", "MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN",
    "TIMER",
}  # fmt: skip
"""Events that reach the rest of Blender while a job runs: looking around is harmless."""


class W2W_OT_run_job(bpy.types.Operator):
    """Work in the background; Esc cancels"""

    bl_idname = "w2w.run_job"
    bl_label = "W2W Job"
    bl_options = {"INTERNAL"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Hold input back from this window; the timer of the first drives the job, others see its end."""
        job = jobs.running
        if job is None:
            return {"CANCELLED"}
        self.job, self.window = job, context.window.as_pointer()
        self.shown, self.due = 0.0, float("-inf")
        self.drives, manager = not job.windows, context.window_manager
        seconds = TICK if self.drives else SHOWN_EVERY
        job.windows[self.window] = manager.event_timer_add(seconds, window=context.window)
        manager.modal_handler_add(self)
        if self.drives:
            self.show(context)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        job = self.job
        if jobs.running is not job:  # it was ended in another window
            self.leave(context)
            return {"CANCELLED", "PASS_THROUGH"}
        stopped = event.type == "ESC" and event.value == "PRESS"
        if not stopped and not (self.drives and event.type == "TIMER"):
            return {"PASS_THROUGH"} if event.type in PASSED_ON else {"RUNNING_MODAL"}
        if self.shown:  # the first turn since a redraw
            took = time.monotonic() - self.shown
            self.shown, self.due = 0.0, max(self.due, self.shown + took / DRAWING)
        try:
            text = job.stop() if stopped else advance(job, BUDGET)
            if text is None:
                self.show(context)
                return {"RUNNING_MODAL"}
        except Exception as error:
            show_error(self, job.why_failed(error))
            stopped = True
        else:
            jobs.message = Message(harmless(text), False, job.title, context.scene.name)
            if not stopped:
                self.report({"INFO"}, jobs.message.text)
        jobs.running = None
        self.leave(context)
        _clear_windows()
        if not stopped or job.kept():
            bpy.ops.ed.undo_push(message=job.title)
        return {"CANCELLED"} if stopped else {"FINISHED"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator itself: a window is closed, another file is opened, or Blender quits."""
        self.leave(context)
        if jobs.running is self.job and self.drives:
            abandon(self.job)
            bpy.app.timers.register(_clear_windows, first_interval=0.0)  # context must stay as it is here

    def leave(self, context: bpy.types.Context) -> None:
        """Stop this window's timer."""
        if timer := self.job.windows.pop(self.window, None):  # a later window may have its address
            context.window_manager.event_timer_remove(timer)

    def show(self, context: bpy.types.Context) -> None:
        """Progress in the status bars and, by a redraw, in the panel; what else there is to see stays."""
        now, job = time.monotonic(), self.job
        if now < self.due:
            return
        self.shown, self.due = now, now + SHOWN_EVERY
        for window in context.window_manager.windows:
            if window.as_pointer() not in job.windows:
                with context.temp_override(window=window):
                    bpy.ops.w2w.run_job("INVOKE_DEFAULT")
        _set_status(context, f"{job.title}: {job.how_far()}   {job.text}      Esc: cancel")
        for area in views(context):
            for region in area.regions:
                if region.type == "UI":
                    region.tag_redraw()


def abandon(job: jobs.Job) -> None:
    """End a job that no window drives any more, as Esc does."""
    try:
        jobs.message = Message(job.stop(), False, job.title)
    except Exception as error:
        jobs.message = Message(job.why_failed(error), True, job.title)
    jobs.running = None


def _clear_windows() -> None:
    """Take progress away from every window."""
    _set_status(bpy.context, None)
    jobs.redraw(bpy.context)


def _set_status(context: bpy.types.Context, text: str | None) -> None:
    """Set the text of every window's status bar: Blender redraws only that of the context's window."""
    for window in context.window_manager.windows:
        with context.temp_override(window=window):
            window.workspace.status_text_set(text)


def unregister() -> None:
    """End the running job, since no window would."""
    job = jobs.running
    if job is not None:
        abandon(job)
        for timer in job.windows.values():
            bpy.context.window_manager.event_timer_remove(timer)
        _clear_windows()
