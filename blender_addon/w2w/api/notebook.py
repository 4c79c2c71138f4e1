# SPDX-License-Identifier: GPL-3.0-or-later
"""A progress bar where Python runs in a notebook; a script or a terminal shows none."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

T = TypeVar("T")


def progress_bar(label: str) -> Callable[[float], None]:
    """A function that shows the fraction done in the notebook's cell, or does nothing outside of one."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if not hasattr(shell, "kernel"):
        return lambda _: None
    from IPython.display import ProgressBar

    class Labelled(ProgressBar):
        def __repr__(self) -> str:
            return f"{label} {super().__repr__()}"

        def _repr_html_(self) -> str:
            return f"{label} {super()._repr_html_()}"

    bar = Labelled(100)
    bar.display()

    def show(fraction: float) -> None:
        if (percent := round(100 * fraction)) != bar.progress:
            bar.progress = percent

    return show


def tracked(items: Sequence[T], label: str) -> Iterator[T]:
    """Go through items, and show how far it has come."""
    show = progress_bar(label)
    for done, item in enumerate(items, start=1):
        yield item
        show(done / len(items))
