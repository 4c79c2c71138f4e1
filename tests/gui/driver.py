# SPDX-License-Identifier: GPL-3.0-or-later
"""Drive a real Blender window: find buttons by what they do, click them, wait for what they start.

Runs inside Blender, started with --enable-event-simulate. A script is a generator: each `yield` gives the
window a turn, as after every event of a real mouse.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
import traceback
from collections.abc import Generator
from pathlib import Path

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

ROW = 7
"""Pixels between two tries when a panel is searched for a button: less than half a row."""

HEADER = 32
"""Pixels from a panel's last button to the header of the next one."""

Script = Generator[None, None, None]


class Driver:
    """Mouse, keyboard and eyes on the first window.

    Parameters
    ----------
    pictures : Path
        Folder for screenshots.
    """

    def __init__(self, pictures: Path) -> None:
        self.pictures = pictures
        self.pictures.mkdir(parents=True, exist_ok=True)

    @property
    def window(self) -> bpy.types.Window:
        """The main window."""
        return bpy.context.window_manager.windows[0]

    @property
    def area(self) -> bpy.types.Area:
        """The 3D view."""
        return next(area for area in self.window.screen.areas if area.type == "VIEW_3D")

    def region(self, kind: str) -> bpy.types.Region:
        """A region of the 3D view."""
        return next(region for region in self.area.regions if region.type == kind)

    def turns(self, count: int = 2) -> Script:
        """Let Blender handle events and redraw."""
        for _ in range(count):
            yield

    def until(self, condition: object, seconds: float = 60.0) -> Script:
        """Wait until a callable is true."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f"waited {seconds} s for {condition}")
            yield

    def event(self, kind: str, value: str, x: int, y: int, **keys: bool) -> Script:
        """One event, and a turn for its handlers."""
        self.window.event_simulate(kind, value, x=x, y=y, **keys)
        yield

    def move(self, x: int, y: int) -> Script:
        """Move the mouse."""
        yield from self.event("MOUSEMOVE", "NOTHING", x, y)

    def click(self, x: int, y: int, **keys: bool) -> Script:
        """Click with the left button."""
        yield from self.move(x, y)
        yield from self.move(x + 1, y)
        yield from self.event("LEFTMOUSE", "PRESS", x, y, **keys)
        yield from self.event("LEFTMOUSE", "RELEASE", x, y, **keys)
        yield from self.turns(3)

    def drop(self, paths: list[Path], x: int, y: int) -> Script:
        """Drop files on the window as a file manager does."""
        program = Path(__file__).with_name("drop_files.py")
        height = self.window.height
        mouse = subprocess.Popen(["python3", str(program), str(x), str(height - y), *map(str, paths)])
        yield from self.until(lambda: mouse.poll() is not None, 30)
        if mouse.returncode:
            raise RuntimeError(f"dropping failed with {mouse.returncode}")
        yield from self.turns(10)

    def drag(self, x: int, y: int, distance: int) -> Script:
        """Drag sideways with the left button."""
        yield from self.move(x, y)
        yield from self.move(x + 1, y)
        yield from self.event("LEFTMOUSE", "PRESS", x, y)
        for step in range(1, 11):
            yield from self.move(x + distance * step // 10, y)
        yield from self.event("LEFTMOUSE", "RELEASE", x + distance, y)
        yield from self.turns(3)

    def scroll_sidebar(self, clicks: int) -> Script:
        """Turn the mouse wheel over the sidebar, downwards."""
        region = self.region("UI")
        x, y = region.x + 12, region.y + 30  # away from lists, which would scroll instead
        yield from self.move(x, y)
        for _ in range(clicks):
            yield from self.event("WHEELDOWNMOUSE", "PRESS", x, y)
        yield from self.turns(30)

    def scroll_sidebar_to_top(self) -> Script:
        """Turn the mouse wheel over the sidebar, upwards, as far as it goes."""
        region = self.region("UI")
        x, y = region.x + 12, region.y + 30
        yield from self.move(x, y)
        for _ in range(60):
            yield from self.event("WHEELUPMOUSE", "PRESS", x, y)
        yield from self.turns(30)

    def open_panel_below(self, wanted: str) -> Script:
        """Click the header of the closed panel under the last button of another."""
        _, y = yield from self.find(wanted)
        left = self.region("UI").x + 60
        yield from self.click(left, y - HEADER)
        yield from self.turns(30)

    def on_screen(self, place: tuple[float, float, float]) -> tuple[int, int]:
        """Where a point of the world is in the window."""
        region = self.region("WINDOW")
        point = location_3d_to_region_2d(region, self.area.spaces.active.region_3d, Vector(place))
        return region.x + round(point.x), region.y + round(point.y)

    def key(self, kind: str, **keys: bool) -> Script:
        """Press and release a key over the 3D view's middle."""
        region = self.region("WINDOW")
        x, y = region.x + region.width // 2, region.y + region.height // 2
        yield from self.move(x, y)
        yield from self.event(kind, "PRESS", x, y, **keys)
        yield from self.event(kind, "RELEASE", x, y, **keys)
        yield from self.turns(3)

    def find(self, wanted: str) -> Generator[None, None, tuple[int, int]]:
        """Where the sidebar's button is whose operator or property path holds this text.

        The mouse goes down the sidebar as a person's would, and Blender is asked what lies under it.
        """
        region = self.region("UI")
        seen = []
        for share in (0.3, 0.7, 0.835, 0.5):
            for y in range(region.y + region.height - 10, region.y, -ROW):
                x = region.x + int(share * region.width)
                yield from self.move(x, y)
                under = self.under_mouse(region)
                if under and under not in seen:
                    seen.append(under)
                if wanted in under:
                    # the highlight follows the mouse a redraw later: make sure where the button is
                    for near in (y - ROW, y, y + ROW):
                        yield from self.move(x, near - 1)
                        yield from self.move(x, near)
                        yield from self.turns(2)
                        if wanted in self.under_mouse(region):
                            return x, near
        raise LookupError(f"the sidebar has no button for {wanted!r}, only {seen}")

    def reach(self, wanted: str) -> Generator[None, None, tuple[int, int]]:
        """Scroll the sidebar down until a button is in view; where it is."""
        for _ in range(8):
            try:
                return (yield from self.find(wanted))
            except LookupError:
                yield from self.scroll_sidebar(4)
        return (yield from self.find(wanted))

    def press(self, wanted: str) -> Script:
        """Find a button of the sidebar and click it."""
        x, y = yield from self.find(wanted)
        yield from self.click(x, y)

    def under_mouse(self, region: bpy.types.Region) -> str:
        """Command of the button under the mouse, or the path of its property."""
        manager = bpy.context.window_manager
        with bpy.context.temp_override(window=self.window, area=self.area, region=region):
            for operator in (bpy.ops.ui.copy_python_command_button, bpy.ops.ui.copy_data_path_button):
                manager.clipboard = ""
                if operator.poll():
                    try:
                        operator()
                    except RuntimeError:
                        continue
                if manager.clipboard:
                    return manager.clipboard
        return ""

    def look(self, name: str) -> Script:
        """Save a picture of the whole screen."""
        self.area.tag_redraw()
        yield from self.turns(4)
        self.photograph(name)

    def photograph(self, name: str) -> None:
        """Save a picture of the screen as it is."""
        subprocess.run(["import", "-window", "root", str(self.pictures / f"{name}.png")], check=True)


def run(script: Script) -> None:
    """Run a script turn by turn, then quit Blender: with 0 when all went well."""

    def turn() -> float | None:
        try:
            next(script)
        except StopIteration:
            _quit(0)
            return None
        except BaseException:
            traceback.print_exc()
            picture = str(Path(os.environ["W2W_OUT"]) / "pictures" / "failed.png")
            subprocess.run(["import", "-window", "root", picture], check=False)
            _quit(1)
            return None
        return 0.005

    view = bpy.context.preferences.view
    view.show_splash = False
    view.show_developer_ui = True  # or Blender would not tell what the button under the mouse does
    bpy.app.timers.register(turn, first_interval=1.0, persistent=True)


def _quit(code: int) -> None:
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
