# SPDX-License-Identifier: GPL-3.0-or-later
"""The run-up reaches back less far where legs or arms would sink into the body there."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS
from w2w.core.motion.motion import Motion
from w2w.scene.cloth import bake as following
from w2w.scene.cloth.bake import DressedBody, cover_of, follow
from w2w.scene.cloth.clear import REACHES, clear_reach
from w2w.scene.cloth.garments import dress


def turning(body, speed, joint="right_hip", start=0.0):
    """A body that stands in the T-pose but for one joint, which turns about the axis from back to front."""
    rotations = np.tile(np.eye(3), (5, N_JOINTS, 1, 1))
    angles = start + speed * np.arange(5) / 60
    rotations[:, JOINT_INDEX[joint]] = Rotation.from_euler("y", angles[:, None]).as_matrix()
    return Motion(rotations, np.tile(body.joints[0], (5, 1)), 60.0)


def test_a_body_at_rest_has_the_whole_run_up(bundled_body):
    assert clear_reach(bundled_body, turning(bundled_body, 0.0)) == 1


@pytest.mark.slow
def test_far_from_the_origin_it_is_the_same(bundled_body):
    """Single precision would not tell a limb from the next there."""
    near = turning(bundled_body, 4.0)
    far = Motion(near.rotations, near.pelvis + (5e5, 5e6, 300.0), near.rate)
    assert clear_reach(bundled_body, far) == clear_reach(bundled_body, near)


@pytest.mark.slow
def test_a_leg_that_would_come_through_the_other_does_not_reach_so_far_back(bundled_body):
    reaches = [clear_reach(bundled_body, turning(bundled_body, speed)) for speed in (-4.0, 4.0)]
    assert min(reaches) < 1
    assert max(reaches) == 1
    assert set(reaches) <= set(REACHES)


@pytest.mark.slow
def test_an_arm_that_would_come_out_of_the_trunk_does_not_reach_so_far_back(bundled_body):
    down = turning(bundled_body, -5.0, "left_shoulder", start=1.0)
    assert clear_reach(bundled_body, down) < 1
    assert clear_reach(bundled_body, turning(bundled_body, 5.0, "left_shoulder", start=1.0)) == 1


def test_a_clip_that_begins_sunk_keeps_its_run_up(bundled_body):
    assert clear_reach(bundled_body, turning(bundled_body, 0.0, "left_shoulder", start=1.6)) == 1


@pytest.mark.slow
def test_the_body_goes_by_it_with_a_garment_on(body_in_scene, bundled_body, patches, monkeypatch):
    item = dress(body_in_scene.mesh, "trousers")
    asked = []
    usual = following.with_run_up
    monkeypatch.setattr(following, "clear_reach", lambda *_: 0.25)
    monkeypatch.setattr(following, "with_run_up", lambda *given: asked.append(given[1:]) or usual(*given))
    own = cover_of(item, body_in_scene.mesh, patches)
    frames = follow(DressedBody(body_in_scene.mesh, [item], [own]), turning(bundled_body, 1.0), patches)
    next(frames)
    frames.close()
    assert asked == [(0.25,)]
