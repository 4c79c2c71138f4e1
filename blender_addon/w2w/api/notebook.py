# SPDX-License-Identifier: GPL-3.0-or-later
"""Display in Python: progress in a notebook or on a terminal, rows as a table."""

import sys
from collections.abc import Callable, Iterator, Sequence
from html import escape
from typing import Any, TypeVar

T = TypeVar("T")


def progress_bar(label: str) -> Callable[[float], None]:
    """A function that shows the fraction done in the notebook's cell or on the terminal, if there is one."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if not hasattr(shell, "kernel"):
        return _on_terminal(label) if sys.stderr.isatty() else lambda _: None
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


def _on_terminal(label: str) -> Callable[[float], None]:
    """A function that shows the fraction done in one line, which it ends when all is done."""
    shown = -1

    def show(fraction: float) -> None:
        nonlocal shown
        if (percent := round(100 * fraction)) != shown:
            shown = percent
            print(f"\r{label}: {percent} %", end="\n" if percent >= 100 else "", file=sys.stderr, flush=True)

    return show


def tracked(items: Sequence[T], label: str) -> Iterator[T]:
    """Go through items, and show how far it has come."""
    show = progress_bar(label)
    for done, item in enumerate(items, start=1):
        yield item
        show(done / len(items))


class Rows(list[dict[str, Any]]):
    """Rows of values by column, all with the same columns."""

    def _repr_html_(self) -> str:
        """The table in a notebook: three digits, as people compare them."""
        heads = "".join(f"<th>{escape(name)}" for name in (self[0] if self else ()))
        rows = ("".join(f"<td>{_cell(value)}" for value in row.values()) for row in self)
        return f"<table><tr>{heads}{''.join(f'<tr>{row}' for row in rows)}</table>"


def _cell(value: Any) -> str:
    return f"{value:.3f}" if isinstance(value, float) else escape(str(value))
