# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w status`: watch a run from another terminal."""

import time
from pathlib import Path
from typing import Annotated

from filelock import FileLock, Timeout

from ...core.given import ForeignFileError, inside
from ...core.study.clip_files import WORK
from ...core.study.results import check_finished
from ..console import USAGE, Terminal, ending
from ..options import argument
from ..runs.folder import HOLDER, LOCK
from ..runs.monitor import RunState, read_state


def status(out: Annotated[Path, argument("OUT", "The results folder of a run.")]) -> None:
    """Say how far the run in a results folder has come.

    Exit codes: 0 there is a run, 2 no run was ever started there, 4 a stopped run left OUT unfinished.
    """
    console = Terminal()
    with ending(USAGE, console):
        inside(out, f"{WORK}/{LOCK}")
        try:
            state = read_state(out)
        except ForeignFileError:
            raise
        except (OSError, ValueError, TypeError, RecursionError) as error:
            check_finished(out)
            raise ValueError(f"No run was started in {out}.") from error
    running = is_running(out)
    console.print(describe(state, running))
    if not running:
        with ending(USAGE, console):
            check_finished(out)


def is_running(out: Path) -> bool:
    """Whether a process holds the folder; where none can be held from here, whether one says that it does."""
    try:
        with FileLock(out / WORK / LOCK).acquire(timeout=0):
            return False
    except Timeout:
        return True
    except OSError:  # a read-only file system, or somebody else's folder
        return (out / WORK / HOLDER).exists()


def describe(state: RunState, running: bool) -> str:
    """The state of a run in a sentence."""
    clips = f"{state.done} of {state.clips} clips done, {state.skipped} of them skipped"
    if state.step in ("finished", "failed"):
        ending = f" {state.message}" if state.message else ""
        return f"{state.step.capitalize()} after {_minutes(state.spent)}: {clips}.{ending}"
    if not running:
        halt = f"Stopped after {_minutes(state.spent)} while {state.step}"
        return f"{halt}: {clips}. The same command goes on from here."
    so_far = state.spent + max(0.0, time.time() - state.updated)
    text = f"Running for {_minutes(so_far)}, now {state.step}: {clips}."
    if 0 < state.done < state.clips:
        text += f" About {_minutes(state.spent / state.done * (state.clips - state.done))} of clips left."
    return text


def _minutes(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes:02d} min"
    return f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"
