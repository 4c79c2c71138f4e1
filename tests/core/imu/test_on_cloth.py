"""What sensors on a garment feel takes the place of what the skin under them feels, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.imu.cover import ClothSensors
from w2w.core.motion.skinning import patch_matrices
from w2w.core.patches.patches import sample_patches
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import record_baked, simulate

from ...sensor_steps import assert_same_to_one_step


@pytest.fixture(scope="module")
def some_patches(bundled_body):
    return sample_patches(bundled_body, n=24, seed=1)


def offset_by(matrices, offset):
    moved = matrices.copy()
    moved[..., :3, 3] += moved[..., :3, :3] @ offset
    return moved


def test_a_garment_that_is_the_skin_feels_what_the_skin_feels(bundled_body, some_patches, waving):
    config = StudyConfig(sensor="bmi270")
    matrices = patch_matrices(bundled_body, some_patches.triangles, waving)
    chosen = np.array([3, 11, 20])
    on_cloth = ClothSensors(chosen, matrices[:, chosen], waving.rate)
    skin, cloth = (simulate(bundled_body, some_patches, waving, config, w) for w in (None, on_cloth))
    assert_same_to_one_step(cloth, skin, config.sensor_model())
    assert cloth.sites == skin.sites
    assert (cloth.activity, cloth.subject, cloth.clip) == ("waving", "one", "clip")


def test_a_rigid_offset_adds_its_lever_arm(bundled_body, some_patches, waving):
    config, offset = StudyConfig(sensor="ideal"), np.array([0.0, 0.0, 0.05])
    matrices = patch_matrices(bundled_body, some_patches.triangles, waving)
    chosen = np.array([5, 9])
    on_cloth = ClothSensors(chosen, offset_by(matrices[:, chosen], offset), waving.rate)
    skin, cloth = (simulate(bundled_body, some_patches, waving, config, w) for w in (None, on_cloth))
    others = np.setdiff1d(np.arange(24), chosen)
    np.testing.assert_array_equal(cloth.acc[:, others], skin.acc[:, others])
    np.testing.assert_allclose(cloth.gyr, skin.gyr, atol=1e-5)
    spin = skin.gyr[:, chosen].astype(float)
    angular = np.gradient(spin, 1 / skin.rate, axis=0)
    lever = np.cross(angular, offset) + np.cross(spin, np.cross(spin, offset))
    found = cloth.acc[:, chosen] - skin.acc[:, chosen]
    inside = slice(5, -5)
    assert np.abs(lever[inside]).max() > 0.1
    np.testing.assert_allclose(found[inside], lever[inside], atol=0.12 * np.abs(lever).max())


def test_carried_to_another_pose_a_sensor_keeps_its_place_over_its_patch(bundled_body, some_patches, waving):
    there, here = (
        patch_matrices(bundled_body, some_patches.triangles, motion)[:, [4, 7]]
        for motion in (waving, replace(waving, rotations=waving.rotations[::-1]))
    )
    offset = np.array([0.01, -0.02, 0.03])
    on_cloth = ClothSensors(np.array([4, 7]), offset_by(there, offset), waving.rate, {"cap": 5})
    carried = on_cloth.carried(there, here)
    np.testing.assert_allclose(carried.matrices, offset_by(here, offset), atol=1e-9)
    assert np.abs(here - there).max() > 0.1
    assert carried.caught == {"cap": 5}


def test_the_panels_door_gives_the_same(bundled_body, some_patches, waving):
    config = StudyConfig(sensor="bmi270")
    matrices = patch_matrices(bundled_body, some_patches.triangles, waving)
    moved = offset_by(matrices[:, [2]], np.array([0.0, 0.0, 0.03]))
    on_cloth = ClothSensors(np.array([2]), moved, waving.rate)
    labels = (waving.activity, waving.subject, waving.clip)
    baked = record_baked(matrices, waving.rate, some_patches, labels, config, on_cloth=on_cloth)
    run = simulate(bundled_body, some_patches, waving, config, on_cloth)
    assert_same_to_one_step(baked, run, config.sensor_model())


def test_frames_that_end_too_early_are_refused(bundled_body, some_patches, waving):
    matrices = patch_matrices(bundled_body, some_patches.triangles[:1], waving)
    on_cloth = ClothSensors(np.array([0]), matrices[:30], waving.rate)
    with pytest.raises(ValueError, match="frames end before the clip does"):
        simulate(bundled_body, some_patches, waving, StudyConfig(), on_cloth)


def test_frames_of_another_rate_are_at_the_same_times(bundled_body, some_patches, waving):
    config = StudyConfig(sensor="ideal")
    slow = replace(waving, rotations=waving.rotations[::2], pelvis=waving.pelvis[::2], rate=15.0)
    matrices = patch_matrices(bundled_body, some_patches.triangles[:1], waving)
    longer = np.concatenate([matrices, matrices[-1:]])
    alone = simulate(bundled_body, some_patches, slow, config, ClothSensors(np.array([0]), longer, 30.0))
    quick = simulate(bundled_body, some_patches, waving, config)
    count = alone.n_samples
    error = alone.acc[10 : count - 10, 0] - quick.acc[10 : count - 10, 0]
    assert np.sqrt((error**2).mean()) < 0.2 * quick.acc[:, 0].std()
