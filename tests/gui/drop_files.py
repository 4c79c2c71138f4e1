# SPDX-License-Identifier: GPL-3.0-or-later
"""Drop files on a window as a file manager does: the source's side of the XDND protocol, version 5.

    python3 drop_files.py X Y FILE...

X and Y are pixels of the screen. Ends with exit status 0 when the window under them has taken the files.
https://freedesktop.org/wiki/Specifications/XDND/
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from Xlib import X, Xatom, display
from Xlib.protocol import event

VERSION = 5
PATIENCE_S = 20


class Source:
    """A window that offers files.

    Parameters
    ----------
    paths : list of Path
    """

    def __init__(self, paths: list[Path]) -> None:
        self.display = display.Display()
        self.root = self.display.screen().root
        self.window = self.root.create_window(0, 0, 1, 1, 0, X.CopyFromParent)
        self.content = "".join(f"{path.resolve().as_uri()}\r\n" for path in paths).encode()

    def atom(self, name: str) -> int:
        """Number of a name."""
        return self.display.intern_atom(name)

    def drop(self, x: int, y: int) -> None:
        """Enter the window at a place, wait for its consent, drop, hand over the paths."""
        target = self.target(x, y)
        self.window.set_selection_owner(self.atom("XdndSelection"), X.CurrentTime)
        self.tell(target, "XdndEnter", VERSION << 24, self.atom("text/uri-list"), 0, 0)
        place = (0, x << 16 | y, X.CurrentTime, self.atom("XdndActionCopy"))
        self.tell(target, "XdndPosition", *place)
        self.wait_for("XdndStatus")
        self.tell(target, "XdndDrop", 0, X.CurrentTime, 0, 0)
        self.wait_for("XdndFinished")

    def target(self, x: int, y: int) -> object:
        """The window at a place that takes drops."""
        for window in reversed(self.root.query_tree().children):
            if window.get_full_property(self.atom("XdndAware"), Xatom.ATOM) is None:
                continue
            box = window.get_geometry()
            if box.x <= x < box.x + box.width and box.y <= y < box.y + box.height:
                return window
        raise SystemExit(f"no window at {x}, {y} takes drops")

    def tell(self, target: object, kind: str, *data: int) -> None:
        """Send the target a message."""
        message = event.ClientMessage(
            window=target, client_type=self.atom(kind), data=(32, (self.window.id, *data))
        )
        target.send_event(message, event_mask=0)
        self.display.flush()

    def wait_for(self, kind: str) -> None:
        """Answer the target's questions until its message of a kind comes."""
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            if not self.display.pending_events():
                time.sleep(0.01)
                continue
            found = self.display.next_event()
            if found.type == X.SelectionRequest:
                self.hand_over(found)
            elif found.type == X.ClientMessage and found.client_type == self.atom(kind):
                return
        raise SystemExit(f"the window did not answer with {kind} in {PATIENCE_S} s")

    def hand_over(self, request: object) -> None:
        """Write the paths where the target asks for them."""
        request.requestor.change_property(request.property, request.target, 8, self.content)
        answer = event.SelectionNotify(
            time=request.time,
            requestor=request.requestor,
            selection=request.selection,
            target=request.target,
            property=request.property,
        )
        request.requestor.send_event(answer, event_mask=0)
        self.display.flush()


if __name__ == "__main__":
    Source([Path(name) for name in sys.argv[3:]]).drop(int(sys.argv[1]), int(sys.argv[2]))
