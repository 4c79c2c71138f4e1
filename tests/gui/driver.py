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
from collections.abc import Callable, Generator
from contextlib import AbstractContextManager
from pathlib import Path

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

ROW = 18
"""Pixels between two tries when a panel is searched for a button: less than the lowest row has."""

HEADER, CLOSED = 32, 26
"""Pixels from a panel's outermost button to the next header, and from a closed panel's header to the next."""

MENU = 26
"""Pixels from a large button to a menu in the row over it, at a scale of 1."""

BUTTON, MIDDLE, LABEL, FIELD, LAST, IN_HEADER = 0.3, 0.5, 0.55, 0.7, 0.835, 0.79
"""Where across the sidebar stand buttons, the second of three, labels of clips, fields, a row's last, and a
header's."""

TRIES = 8
"""How often the sidebar is scrolled in search of a button."""

Script = Generator[None, None, None]


class Driver:
    """Mouse, keyboard and eyes on a window, the first unless `number` is set.

    Parameters
    ----------
    pictures : Path
        Folder for screenshots.
    """

    def __init__(self, pictures: Path) -> None:
        self.pictures = pictures
        self.pictures.mkdir(parents=True, exist_ok=True)
        self.number = 0
        self.seen: dict[str, float] = {}  # heights in the panel where buttons stood when last passed

    @property
    def window(self) -> bpy.types.Window:
        """The window."""
        return bpy.context.window_manager.windows[self.number]

    @property
    def area(self) -> bpy.types.Area:
        """The 3D view."""
        return next(area for area in self.window.screen.areas if area.type == "VIEW_3D")

    def region(self, kind: str) -> bpy.types.Region:
        """A region of the 3D view."""
        return next(region for region in self.area.regions if region.type == kind)

    def foot_of_outliner(self) -> list[int]:
        """Where the lower left corner of the Outliner is in a picture."""
        (area,) = (area for area in self.window.screen.areas if area.type == "OUTLINER")
        region = next(region for region in area.regions if region.type == "WINDOW")
        return [region.x, self.window.height - region.y]

    def turns(self, count: int = 2) -> Script:
        """Let Blender handle events and redraw."""
        for _ in range(count):
            yield

    def in_view(self) -> AbstractContextManager:
        """Operators called inside work in the 3D view."""
        return bpy.context.temp_override(window=self.window, area=self.area, region=self.region("WINDOW"))

    def until(self, condition: Callable[[], object], seconds: float = 60.0) -> Script:
        """Wait until a callable is true."""
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                raise TimeoutError(f"waited {seconds} s for {condition}")
            yield

    def event(self, kind: str, value: str, x: int, y: int, **keys: bool | str) -> Script:
        """One event, and a turn for its handlers; `keys` are keys held down, and `unicode` a letter."""
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
        """Turn the mouse wheel over the sidebar, downwards, or upwards by a negative number of clicks."""
        region = self.region("UI")
        x, y = region.x + 12, region.y + region.height - 30  # over a panel, or the view would be zoomed
        yield from self.move(x, y)
        for _ in range(abs(clicks)):
            yield from self.event("WHEELDOWNMOUSE" if clicks > 0 else "WHEELUPMOUSE", "PRESS", x, y)
        yield from self.turns(30)

    def scroll_sidebar_to_top(self) -> Script:
        """Turn the mouse wheel over the sidebar, upwards, as far as it goes."""
        region = self.region("UI")
        x, y = region.x + 12, region.y + region.height - 30
        yield from self.move(x, y)
        before = None
        while self.in_panel(y) != before:
            before = self.in_panel(y)
            for _ in range(5):
                yield from self.event("WHEELUPMOUSE", "PRESS", x, y)
            yield from self.turns(5)

    def open_panel_below(self, wanted: str, across: float = BUTTON) -> Script:
        """Click the header of the closed panel under the last button of another."""
        yield from self.click_header(wanted, -HEADER, across)

    def open_panel_above(self, wanted: str) -> Script:
        """Click the header of the closed panel over that of the panel whose first field this is."""
        yield from self.click_header(wanted, HEADER + CLOSED, FIELD)

    def open_panel_with(self, wanted: str) -> Script:
        """Click the header of the panel in whose header this button stands."""
        yield from self.click_header(wanted, 0, IN_HEADER)

    def close_panel(self, wanted: str) -> Script:
        """Click the header of the panel whose first field this is."""
        yield from self.click_header(wanted, HEADER, FIELD)

    def click_header(self, wanted: str, distance: int, across: float) -> Script:
        """Click the header of a panel, so many pixels over a button at a scale of 1."""
        _, y = yield from self.over(wanted, distance, across)
        yield from self.click(self.region("UI").x + 60, y)
        yield from self.turns(30)

    def on_screen(self, place: tuple[float, float, float]) -> tuple[int, int]:
        """Where a point of the world is in the window."""
        region = self.region("WINDOW")
        point = location_3d_to_region_2d(region, self.area.spaces.active.region_3d, Vector(place))
        return region.x + round(point.x), region.y + round(point.y)

    def key(self, kind: str, **keys: bool) -> Script:
        """Press and release a key over the middle of what the sidebar leaves of the 3D view."""
        region, sidebar = self.region("WINDOW"), self.region("UI")
        right = sidebar.x if sidebar.width > 1 else region.x + region.width
        x, y = (region.x + right) // 2, region.y + region.height // 2
        yield from self.move(x, y)
        yield from self.event(kind, "PRESS", x, y, **keys)
        yield from self.event(kind, "RELEASE", x, y, **keys)
        yield from self.turns(3)

    def look_from_the_front(self) -> Script:
        """Turn the view to the front, with all of the scene in it."""
        yield from self.key("NUMPAD_1")
        yield from self.key("HOME")
        yield from self.turns(10)

    def find(
        self, wanted: str, across: tuple[float, ...], below: float = float("inf")
    ) -> Generator[None, None, tuple[int, int]]:
        """Where the sidebar's button is whose operator or property path holds this text.

        The mouse goes down the sidebar as a person's would, and Blender is asked what lies under it.

        Parameters
        ----------
        wanted : str
        across : tuple of float
            Where across the sidebar to look, one after the other.
        below : float
            Height in the panel from which downwards to look: what stands higher was searched before.
        """
        region = self.region("UI")
        rows = [y for y in range(region.y + region.height - 10, region.y, -ROW) if self.in_panel(y) <= below]
        seen = []
        if stood := [height for under, height in self.seen.items() if wanted in under]:
            rows.sort(key=lambda y: self.in_panel(y) > stood[0] + 3 * ROW)
        for share in across:
            x = region.x + int(share * region.width)
            for y in rows:
                yield from self.move(x, y)
                under = self.under_mouse(region)
                if under:
                    seen.append(under)
                    self.seen[under] = self.in_panel(y)
                if wanted in under:
                    # the highlight follows the mouse some redraws later: be sure by the second place in a row
                    was_over = False
                    for near in range(y + ROW, y - ROW, -ROW // 3):
                        yield from self.move(x, near - 1)
                        yield from self.move(x, near)
                        yield from self.turns(2)
                        is_over = wanted in self.under_mouse(region)
                        if is_over and was_over:
                            return x, near
                        was_over = is_over
        raise LookupError(f"the sidebar has no button for {wanted!r}, only {list(dict.fromkeys(seen))}")

    def in_panel(self, y: int) -> float:
        """Height of a row of pixels in the sidebar's content, however far that is scrolled."""
        region = self.region("UI")
        return region.view2d.region_to_view(0, y - region.y)[1]

    def reach(self, wanted: str, across: float = BUTTON) -> Generator[None, None, tuple[int, int]]:
        """Scroll the sidebar down until a button is in view; where it is."""
        searched = float("inf")
        for _ in range(TRIES):
            try:
                return (yield from self.find(wanted, (across,), searched))
            except LookupError:
                lowest = self.in_panel(self.region("UI").y)
                if lowest + 2 * ROW >= searched:
                    raise
                searched = lowest + 2 * ROW
                yield from self.scroll_sidebar(8)
        return (yield from self.find(wanted, (across,), searched))

    def over(
        self, wanted: str, distance: int, across: float = BUTTON
    ) -> Generator[None, None, tuple[int, int]]:
        """Where it is so many pixels over a button at a scale of 1, scrolled into view."""
        x, y = yield from self.reach(wanted, across)
        away, region = round(distance * bpy.context.preferences.system.ui_scale), self.region("UI")
        height = y + away - region.y
        if not ROW < height < region.height - ROW:
            yield from self.scroll_sidebar(3 if height <= ROW else -3)
            x, y = yield from self.find(wanted, (across,))
        return x, y + away

    def press(self, wanted: str, across: float = BUTTON) -> Script:
        """Scroll the sidebar down until a button is in view, and click it."""
        x, y = yield from self.reach(wanted, across)
        yield from self.click(x, y)

    def open_menu_above(self, wanted: str, letter: str) -> Script:
        """Click the menu over a button at the sidebar's left, press the letter that an item underlines."""
        x, y = yield from self.over(wanted, MENU)
        yield from self.click(x, y)
        yield from self.turns(10)
        yield from self.event(letter, "PRESS", x, y)
        yield from self.event(letter, "RELEASE", x, y)
        yield from self.turns(10)

    def fill_in(self, wanted: str, text: str, across: float = BUTTON, **keys: bool) -> Script:
        """Click into a field, `keys` held down, type over what it holds, press Return."""
        x, y = yield from self.reach(wanted, across)
        yield from self.click(x, y, **keys)
        yield from self.turns(5)
        yield from self.event("A", "PRESS", x, y, ctrl=True)
        yield from self.event("A", "RELEASE", x, y, ctrl=True)
        for letter in text:
            yield from self.event("A", "PRESS", x, y, unicode=letter)
            yield from self.event("A", "RELEASE", x, y)
        yield from self.event("RET", "PRESS", x, y)
        yield from self.event("RET", "RELEASE", x, y)
        yield from self.turns(5)

    def choose_folder(self, folder: Path, name: str = "") -> Script:
        """Go to a folder, or a file in it, in the file browser, which has its own window, and accept it."""
        manager = bpy.context.window_manager
        yield from self.until(lambda: len(manager.windows) > 1, 20)
        yield from self.turns(5)
        window = manager.windows[-1]
        area = next(area for area in window.screen.areas if area.type == "FILE_BROWSER")
        area.spaces.active.params.directory = f"{folder}/".encode()
        yield from self.turns(5)
        if name:
            area.spaces.active.params.filename = name
        region = next(region for region in area.regions if region.type == "WINDOW")
        with bpy.context.temp_override(window=window, area=area, region=region):
            bpy.ops.file.execute()

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

    set_preferences()
    bpy.app.timers.register(turn, first_interval=1.0, persistent=True)


def set_preferences() -> None:
    """No splash screen, buttons that tell what they do, and what is quick to draw without a graphics card."""
    view, system = bpy.context.preferences.view, bpy.context.preferences.system
    view.show_splash = False
    view.show_developer_ui = True  # or Blender would not tell what the button under the mouse does
    view.smooth_view = 0
    system.viewport_aa = "OFF"
    system.use_overlay_smooth_wire = system.use_edit_mode_smooth_wire = False


def _quit(code: int) -> None:
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
