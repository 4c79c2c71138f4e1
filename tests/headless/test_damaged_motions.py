# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that import without complaint and hold what no body does: a true sentence, and the others go on."""

import re

import bpy
import numpy as np
import pytest

from w2w.core.library.library import Clip
from w2w.core.motion.source import UnusableMotion
from w2w.headless.runs.workers import load_alone

from ..robustness.fbx_variants import rewrite

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")

WALKING = "mixamo/Conqster__TheBarMan/Walking.fbx"
BVH = "bvh/bandai_namco/dataset-2_raise-up-left-hand_active_001.bvh"
NOT_FINITE = "its animation holds values that no body has (NaN, infinite or beyond 1e10)"


def loaded(path, body):
    return load_alone(Clip(path, path.name, path.stem, "activity"), body)


def changed(source, target, change, name=b"KeyValueFloat"):
    """An FBX file with the arrays of its animation curves changed."""

    def of_curves(element):
        if element.id != name:
            return list(element.props)
        values = np.array(element.props[0])
        return [change(values.copy()).astype(values.dtype), *element.props[1:]]

    assert rewrite(source, target, of_curves)
    return target


def with_middle(value):
    def change(values):
        values[len(values) // 2] = value
        return values

    return change


@pytest.mark.parametrize(
    ("change", "curves", "reason"),
    [
        (with_middle(np.nan), b"KeyValueFloat", NOT_FINITE),
        (with_middle(np.inf), b"KeyValueFloat", NOT_FINITE),
        (lambda values: np.full_like(values, -np.inf), b"KeyValueFloat", NOT_FINITE),
        (lambda values: values * np.float32(1e30), b"KeyValueFloat", NOT_FINITE),
        (
            lambda values: np.full_like(values, values[0]),
            b"KeyValueFloat",
            "it holds a pose, not a motion: nothing moves over the 32 frames of 'mixamo.com'",
        ),
        (
            lambda times: np.full_like(times, times[0]),
            b"KeyTime",
            "it holds a pose, not a motion: 1 frame in 'mixamo.com'",
        ),
    ],
    ids=["NaN", "infinite", "all infinite", "huge", "still", "zero length"],
)
def test_an_fbx_of_values_no_body_has(shared_data, bundled_body, tmp_path, change, curves, reason):
    path = changed(shared_data / WALKING, tmp_path / "walking.fbx", change, curves)
    with pytest.raises(UnusableMotion) as said:
        loaded(path, bundled_body)
    assert str(said.value).startswith(reason)


@pytest.mark.parametrize("value", ["nan", "-nan(ind)", "inf", "-Infinity", "1.#QNAN", "1e999", "3.4E+38"])
@pytest.mark.parametrize("column", [0, 7])
def test_a_bvh_of_values_that_are_not_finite(shared_data, bundled_body, tmp_path, value, column):
    head, motion, frames = (shared_data / BVH).read_text().partition("MOTION")
    lines = frames.splitlines()
    row = lines[20].split()
    lines[20] = " ".join([*row[:column], value, *row[column + 1 :]])
    path = tmp_path / "damaged.bvh"
    path.write_text(head + motion + "\n".join(lines))
    with pytest.raises(UnusableMotion) as said:
        loaded(path, bundled_body)
    assert str(said.value) == NOT_FINITE


def test_a_bvh_of_a_bone_that_is_endless(shared_data, bundled_body, tmp_path):
    text = re.sub(r"OFFSET\s+\S+", "OFFSET nan", (shared_data / BVH).read_text(), count=3)
    path = tmp_path / "damaged.bvh"
    path.write_text(text)
    with pytest.raises(UnusableMotion) as said:
        loaded(path, bundled_body)
    assert str(said.value) == NOT_FINITE


def two_people(first, second, target):
    """An FBX file of two armatures, each with a motion of its own."""
    bpy.ops.preferences.addon_enable(module="io_scene_fbx")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    for file in (first, second):
        bpy.ops.wm.fbx_import(filepath=str(file))
    bpy.context.scene.frame_end = 30
    bpy.ops.export_scene.fbx(
        filepath=str(target), object_types={"ARMATURE"}, add_leaf_bones=False,
        bake_anim_use_nla_strips=False, bake_anim_use_all_actions=False,
    )  # fmt: skip
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def hand_path(motion):
    return np.abs(np.diff(motion.rotations[:, 18:20], axis=0)).sum() / motion.duration


@pytest.mark.slow
def test_of_two_people_the_one_that_moves_is_used_and_it_is_said(shared_data, bundled_body, tmp_path):
    still = changed(
        shared_data / WALKING, tmp_path / "still.fbx", lambda values: np.full_like(values, values[0])
    )
    alone = hand_path(loaded(shared_data / WALKING, bundled_body)[1])
    for order in ((shared_data / WALKING, still), (still, shared_data / WALKING)):
        both = tmp_path / "both.fbx"
        two_people(*order, both)
        source, motion, details = loaded(both, bundled_body)
        assert details["people"] == source.people == 2
        assert motion.n_frames > 16
        assert hand_path(motion) == pytest.approx(alone, rel=0.3)


def test_two_people_of_one_bvh_are_said(shared_data, bundled_body, tmp_path):
    head, _, frames = (shared_data / BVH).read_text().partition("MOTION")
    skeleton = head.partition("HIERARCHY")[2]
    rows = [line for line in frames.splitlines() if line.strip()]
    doubled = [*rows[:2], *(f"{row} {row}" for row in rows[2:])]
    path = tmp_path / "two.bvh"
    path.write_text("\n".join(["HIERARCHY" + skeleton + skeleton + "MOTION", *doubled]))
    _, motion, details = loaded(path, bundled_body)
    assert details["people"] == 2
    _, alone, details = loaded(shared_data / BVH, bundled_body)
    assert "people" not in details
    np.testing.assert_allclose(motion.rotations, alone.rotations, atol=1e-3)
