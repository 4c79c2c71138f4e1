# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of W2W's own that are cut, empty or something else: one sentence that names the file."""

from __future__ import annotations

import numpy as np
import pytest

from w2w.core.body.body import TEMPLATES, Body
from w2w.core.body.shapes import ShapeTargets
from w2w.core.imu.recording import ImuRecording
from w2w.core.motion.motion import Motion
from w2w.core.patches.patches import PatchSet, sample_patches
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import UtilityMap, utility_map


@pytest.fixture(scope="module")
def files(bundled_body, tmp_path_factory):
    """A whole file of each kind."""
    folder = tmp_path_factory.mktemp("whole")
    bundled_body.save(folder / "Body.npz")
    sample_patches(bundled_body, 8).save(folder / "PatchSet.npz")
    rng = np.random.default_rng(1)
    labels = np.repeat(["a", "b"], 20)
    clips = np.repeat(np.arange(8), 5)
    features = rng.normal(size=(40, 4, 3)).astype(np.float32)
    utility_map(features, CrossValidation(labels, clips, None, np.ones(40, bool), ["a", "b"])).save(
        folder / "UtilityMap.npz"
    )
    ImuRecording(np.zeros((9, 1, 3)), np.zeros((9, 1, 3)), 50.0).save(folder / "ImuRecording.npz")
    Motion(np.tile(np.eye(3), (9, 24, 1, 1)), np.zeros((9, 3)), 30.0).save(folder / "Motion.npz")
    (folder / "ShapeTargets.npz").write_bytes((TEMPLATES / "shapes.npz").read_bytes())
    return folder


KINDS = [Body, PatchSet, UtilityMap, ImuRecording, Motion, ShapeTargets]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_a_whole_file_is_read(files, kind):
    assert isinstance(kind.load(files / f"{kind.__name__}.npz"), kind)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("damage", ["cut in half", "empty", "no zip", "one byte changed", "another kind"])
def test_a_damaged_file_is_said_by_name(files, tmp_path, kind, damage):
    content = (files / f"{kind.__name__}.npz").read_bytes()
    path = tmp_path / "damaged.npz"
    if damage == "one byte changed":
        middle = len(content) // 3
        path.write_bytes(content[:middle] + bytes([content[middle] ^ 255]) + content[middle + 1 :])
    elif damage == "another kind":
        np.savez(path, something=np.zeros(3))
    else:
        path.write_bytes(
            {"cut in half": content[: len(content) // 2], "empty": b"", "no zip": b"PK no"}[damage]
        )
    with pytest.raises(ValueError, match=r"damaged\.npz"):
        kind.load(path)
