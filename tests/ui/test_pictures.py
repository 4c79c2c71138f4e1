# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture to show has the shape that was chosen, whole, with room around it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from w2w.ui.files.pictures import save_shaped


@pytest.mark.parametrize("size", [(300, 400), (900, 100)])
@pytest.mark.parametrize(("shape", "ratio"), [("WIDE", 16 / 9), ("SQUARE", 1.0)])
def test_a_picture_gets_room_around_it_and_loses_nothing(
    tmp_path: Path, size: tuple[int, int], shape: str, ratio: float
) -> None:
    save_shaped(tmp_path / "a.png", Image.new("RGBA", size, "#ff0000ff"), shape, "#ffffff00")
    with Image.open(tmp_path / "a.png") as saved:
        pixels = np.array(saved)
    height, width, _ = pixels.shape
    assert width / height == pytest.approx(ratio, abs=0.01)
    shown = pixels[..., 3] > 0
    assert shown.sum() == size[0] * size[1]
    assert (pixels[shown] == (255, 0, 0, 255)).all()
