# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work in small steps: the window stays alive, a progress bar shows, Esc cancels.

A job is a generator that yields its `Step`s. It changes Blender's data only between yields, cleans up in
`finally`, and puts everything back when it is closed early (GeneratorExit) or fails. In a window a modal
operator (`windows`) runs it a few milliseconds at a time; without one it runs through at once. A job on a
body ends with an error if that body is removed or edited meanwhile (`on_body`).
"""

import time
import traceback
from collections.abc import Callable, Generator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from functools import wraps
from typing import NamedTuple, TypeVar

import bpy

from ...core.motion.source import UnusableMotion
from ...core.threads import unthreaded_products
from ...core.wording import harmless
from ...scene.base.steps import each_as

POLL = 0.02
"""Seconds to wait for a thread or a process before the window gets its turn."""

KNOWN_FROM, KNOWN_AFTER = 0.03, 3.0
"""Fraction done, and seconds spent, from which the time left can be estimated."""

EXPECTED = (ValueError, UnusableMotion, OSError, ImportError)
"""Errors that core and scene raise with a sentence for people."""

GONE = "The body was removed while this ran: nothing of it was kept"
EDITED = "The body was put into Edit Mode while this ran: leave Edit Mode and start again"

T = TypeVar("T")


class Step(NamedTuple):
    """Progress of a job."""

    fraction: float
    text: str


Steps = Generator[Step, None, str]
"""Yields steps and returns what was done, as a sentence."""


@dataclass
class Job:
    """A job and how far it is."""

    title: str
    steps: Steps
    kept: Callable[[], str] = str
    """Returns what was done so far and is kept if the job is stopped early, or ""."""
    fraction: float = 0.0
    text: str = ""
    begun: float = field(default_factory=time.monotonic)
    windows: dict[int, bpy.types.Timer] = field(default_factory=dict)
    """The timers of the windows that it holds input back from, by these windows' addresses."""

    def how_far(self) -> str:
        """Percent done and, as soon as it is known, about how long the rest will take."""
        left = time_left(self.fraction, time.monotonic() - self.begun)
        return f"{self.fraction:.0%}, {left}" if left else f"{self.fraction:.0%}"

    def stop(self) -> str:
        """End it early; says what it leaves."""
        self.steps.close()
        kept = self.kept()
        return f"{self.title} stopped: {kept}" if kept else f"{self.title} cancelled: nothing was changed"

    def why_failed(self, error: Exception) -> str:
        """An error as a sentence; the traceback of an unforeseen one goes to the console."""
        if isinstance(error, EXPECTED) and str(error).strip():
            return str(error)
        traceback.print_exception(error)
        if isinstance(error, MemoryError):
            return f"{self.title} needs more memory than is free: close other programs, or take fewer spots"
        what = f"{type(error).__name__}: {error}".rstrip(": ")
        return f"{self.title} failed, please report this and what the system console says: {what}"


@dataclass(frozen=True)
class Message:
    """The outcome that the panel shows."""

    text: str
    is_error: bool
    job: str = ""
    """Title of its job."""
    scene: str = field(default="", compare=False)
    """Name of the scene that it is about; "" is any."""

    def is_about(self, scene: bpy.types.Scene) -> bool:
        """Whether it is about a scene."""
        return self.scene in ("", scene.name)


running: Job | None = None
message: Message | None = None
pool = ThreadPoolExecutor(2, thread_name_prefix="w2w")


def can_start(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether an operator may work: bones can be made only from object mode, and one job runs at a time."""
    if running is not None:
        cls.poll_message_set("Wait until the running job has finished, or cancel it with Esc")
        return False
    cls.poll_message_set("Go back to object mode first")
    return context.mode == "OBJECT"


def start(
    operator: bpy.types.Operator, context: bpy.types.Context, title: str, steps: Steps,
    kept: Callable[[], str] = str,
) -> set[str]:  # fmt: skip
    """Run a job modally, or at once if there is no window or the operator was executed by a script."""
    global running, message
    if bpy.app.background or context.window is None:
        return run_now(operator, title, steps)
    running, message = Job(title, steps, kept), None
    bpy.ops.w2w.run_job("INVOKE_DEFAULT")
    return {"FINISHED"}


def run_now(operator: bpy.types.Operator, title: str, steps: Steps) -> set[str]:
    """Run a job from its beginning to its end."""
    global running, message
    running, message = Job(title, steps), None
    try:
        return show_done(operator, advance(running, float("inf")) or "")
    except Exception as error:
        return show_error(operator, running.why_failed(error))
    finally:
        running = None


def is_there(item: bpy.types.Object) -> bool:
    """Whether an object is in a scene; a removed object raises ReferenceError."""
    try:
        return any(scene.objects.get(item.name) is item for scene in bpy.data.scenes)
    except ReferenceError:
        return False


def on_body(make: Callable[..., Steps]) -> Callable[..., Steps]:
    """Let a job check before each step that the body it works on, its first argument, is still there."""

    @wraps(make)
    def watched(mesh: bpy.types.Object, *args: object, **options: object) -> Steps:
        steps = make(mesh, *args, **options)
        try:
            with unthreaded_products():  # the same bytes as a run's, and no thread that waits busily
                while is_there(mesh):
                    shown = [mesh, *(part.object for part in mesh.modifiers if part.type == "ARMATURE")]
                    if any(item and item.mode == "EDIT" for item in shown):  # it shows no motion there
                        raise ValueError(EDITED)
                    try:
                        step = next(steps)
                    except StopIteration as stop:
                        return stop.value
                    yield step
            raise ValueError(GONE)
        finally:
            try:
                steps.close()
            except ReferenceError:  # what it would put back went with the body
                if is_there(mesh):
                    raise

    return watched


def in_thread(
    work: Callable[[Callable[[float], None]], T], text: str, low: float, high: float
) -> Generator[Step, None, T]:
    """Do numerical work in a thread while the window stays alive; bpy must not be touched there.

    `work` gets a function that takes the fraction done, and also ends the work when the job is cancelled;
    `low` and `high` are the job's fraction before and after. Returns the work's own result.
    """
    state = {"fraction": 0.0, "stop": False}

    def progress(fraction: float) -> None:
        state["fraction"] = fraction
        if state["stop"]:
            raise CancelledError

    future: Future[T] = pool.submit(work, progress)
    try:
        yield Step(low, text)  # many short ones, too, let the window have its turn
        while not wait([future], POLL).done:
            yield Step(low + (high - low) * state["fraction"], text)
    except GeneratorExit:
        state["stop"] = True
        future.cancel()
        raise
    return future.result()


def part(steps: Generator[Step, None, T], low: float, high: float) -> Generator[Step, None, T]:
    """The steps of one job as a part of another, from one fraction of that to the next."""
    return each_as(steps, lambda step: Step(low + (high - low) * step.fraction, step.text))


def as_steps(
    shares: Generator[float, None, T], text: str, low: float, high: float
) -> Generator[Step, None, T]:
    """The steps of a job, with a text, from work that yields the share done."""
    return each_as(shares, lambda share: Step(low + (high - low) * share, text))


def time_left(fraction: float, seconds: float) -> str:
    """An estimate of the time left for work that has come this far, or "" while it would be a guess."""
    if seconds < KNOWN_AFTER or not KNOWN_FROM <= fraction < 1:
        return ""
    left = seconds * (1 - fraction) / fraction
    return f"about {max(round(left), 1)} s left" if left < 90 else f"about {round(left / 60)} min left"


def show_error(operator: bpy.types.Operator, text: str) -> set[str]:
    """Show what went wrong; returns that the operator was cancelled."""
    _show(operator, "ERROR", text)
    return {"CANCELLED"}


def show_done(operator: bpy.types.Operator, text: str) -> set[str]:
    """Show what was done; returns that the operator has finished."""
    _show(operator, "INFO", text)
    return {"FINISHED"}


def _show(operator: bpy.types.Operator, kind: str, text: str) -> None:
    """Show a message in the status bar, in the panel and, as Blender does, in the terminal."""
    global message
    title = running.title if running is not None else ""
    message = Message(harmless(text), kind == "ERROR", title, bpy.context.scene.name)
    operator.report({kind}, message.text)


def dismiss() -> None:
    """Take the panel's message away."""
    global message
    message = None


def dismiss_error() -> None:
    """Take the panel's message away if it is an error: it is resolved."""
    if message is not None and message.is_error:
        dismiss()


def advance(job: Job, budget: float) -> str | None:
    """Work for a while; returns the job's outcome once it has finished, else None."""
    deadline = time.perf_counter() + budget
    while True:
        try:
            job.fraction, job.text = next(job.steps)
        except StopIteration as stop:
            return str(stop.value)
        if time.perf_counter() >= deadline:
            return None


class W2W_OT_dismiss_message(bpy.types.Operator):
    """Close this message"""

    bl_idname = "w2w.dismiss_message"
    bl_label = "Dismiss Message"
    bl_options = {"INTERNAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        dismiss()
        return {"FINISHED"}


def redraw(context: bpy.types.Context) -> None:
    """Redraw every 3D view."""
    for area in views(context):
        area.tag_redraw()


def views(context: bpy.types.Context) -> list[bpy.types.Area]:
    """Every 3D view."""
    screens = [window.screen for window in context.window_manager.windows]
    return [area for screen in screens for area in screen.areas if area.type == "VIEW_3D"]
