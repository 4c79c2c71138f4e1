# SPDX-License-Identifier: GPL-3.0-or-later
"""What a module of the overlay draws, by its extents instead of on a screen."""

from __future__ import annotations

from types import ModuleType

import pytest

from w2w.ui.viewport import drawing

Extent = tuple[float, float, float, float]


def drawn_on(monkeypatch: pytest.MonkeyPatch, module: ModuleType) -> list[Extent]:
    """Left, bottom, right and top of each text, rectangle and bar, as they come."""
    drawn: list[Extent] = []

    def write(x: float, y: float, words: str, size: float, _colour: object, align: str = "LEFT") -> float:
        width = drawing.width_of(words, size)
        x -= {"LEFT": 0, "RIGHT": width}[align]
        drawn.append((x, y, x + width, y + 0.8 * size))
        return width

    def fill(x: float, y: float, width: float, height: float, *_: object) -> None:
        drawn.append((x, y, x + width, y + height))

    for name, how in (("text", write), ("rectangle", fill), ("bar_of_colours", fill)):
        monkeypatch.setattr(module, name, how, raising=False)
    return drawn
