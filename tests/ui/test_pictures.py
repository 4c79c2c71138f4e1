# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture to show has the shape that was chosen, whole, with room around it, and the body's map."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from PIL import Image

from w2w.scene.base.body import armature_of

from .made_study import make_study


def saved(path: Path, **look: str) -> np.ndarray:
    """The picture that the operator saves."""
    assert bpy.ops.w2w.export_presentation(filepath=str(path), **look) == {"FINISHED"}
    with Image.open(path) as picture:
        return np.array(picture.convert("RGBA"))


def test_a_page_and_a_body_alone_are_saved_without_a_renderer(
    blender: None,  # noqa: ARG001
    library: Path,
    tmp_path: Path,
) -> None:
    body = make_study(library)
    page = saved(tmp_path / "page.png")
    assert page.shape[1] / page.shape[0] == pytest.approx(16 / 9, abs=0.01)
    assert (page[..., 3] == 255).all()
    coloured = np.ptp(page[..., :3].astype(int), axis=-1) > 60
    assert coloured.sum() > 100_000
    armature_of(body).rotation_euler.x = np.pi / 2  # it lies on its back
    alone = saved(
        tmp_path / "alone.png", pose="THIS_FRAME", content="BODY_ALONE", shape="SQUARE", light="FLAT"
    )
    assert alone.shape[0] == alone.shape[1]
    assert alone.shape[0] < 4000
    assert alone[0, 0, 3] == 0
    assert len(bpy.data.scenes) == 1
