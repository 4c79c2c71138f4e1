# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages of the tab W2W: what goes in, what comes out, and all that is rarely set.

Which page is shown is a matter of the window, not of the file: no undo changes it.
"""

import bpy

CLIPS, ANSWER, DETAILS = "CLIPS", "ANSWER", "DETAILS"

PAGES = (
    (CLIPS, "Clips", "The body and its motions, and the button that runs all"),
    (ANSWER, "Answer", "Where to wear a sensor, how good that is, and what other places cost"),
    (DETAILS, "Details", "Spots, sensor, windows and tables: all of it may stay as it is"),
)


def shown_page() -> str:
    """The page that the tab shows."""
    return bpy.context.window_manager.w2w_page


def turn_to(page: str) -> None:
    """Show a page."""
    bpy.context.window_manager.w2w_page = page
