# SPDX-License-Identifier: GPL-3.0-or-later
"""Augmented copies of a clip: each switch does what it says, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.imu.presets import DEFAULT_SENSOR
from w2w.core.imu.virtual import record_motion
from w2w.core.patches.patches import sample_patches
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import record
from w2w.studies.sweep.augmentation import SWITCHES, Augmentation, body_variant, copies_of

IDEAL, REAL = StudyConfig(sensor="ideal"), StudyConfig(sensor=DEFAULT_SENSOR)


@pytest.fixture(scope="module")
def patches(bundled_body):
    return sample_patches(bundled_body, 12, seed=0)


def copies(body, patches, motion, *switches, config=IDEAL, number=2):
    made = list(copies_of(body, patches, motion, config, Augmentation.only(switches, copies=number)))
    assert len(made) == number
    return made


def test_without_a_switch_a_copy_is_the_clip(bundled_body, patches, waving):
    own = record_motion(bundled_body, patches, waving, IDEAL.synthesis)
    for copy in copies(bundled_body, patches, waving):
        np.testing.assert_array_equal(copy.acc, own.acc)
        assert (copy.clip, copy.activity, copy.subject) == (own.clip, own.activity, own.subject)


@pytest.mark.parametrize("switch", SWITCHES)
def test_each_switch_alone_changes_the_recording_and_is_repeatable(bundled_body, patches, waving, switch):
    config = REAL if switch == "noise" else IDEAL
    own = record(bundled_body, patches, waving, config)
    first, second = copies(bundled_body, patches, waving, switch, config=config)
    again, _ = copies(bundled_body, patches, waving, switch, config=config)
    np.testing.assert_array_equal(first.acc, again.acc)
    assert first.acc.shape != own.acc.shape or not np.array_equal(first.acc, own.acc)
    assert first.acc.shape != second.acc.shape or not np.array_equal(first.acc, second.acc)
    if switch == "mirror":  # every other one
        np.testing.assert_array_equal(second.acc, own.acc)


def test_other_noise_is_the_same_motion(bundled_body, patches, waving):
    ideal = record_motion(bundled_body, patches, waving, IDEAL.synthesis)
    for copy in copies(bundled_body, patches, waving, "noise", config=REAL):
        assert 0 < np.abs(copy.gyr - ideal.gyr).mean() < 0.1


def test_remounting_turns_what_is_measured_and_keeps_its_size(bundled_body, patches, waving):
    ideal = record_motion(bundled_body, patches, waving, IDEAL.synthesis)
    for copy in copies(bundled_body, patches, waving, "remount"):
        np.testing.assert_allclose(
            np.linalg.norm(copy.gyr, axis=2), np.linalg.norm(ideal.gyr, axis=2), atol=1e-4
        )


def test_other_bodies_stay_on_the_same_patches_and_move_alike(bundled_body, patches, waving):
    ideal = record_motion(bundled_body, patches, waving, IDEAL.synthesis)
    for copy in copies(bundled_body, patches, waving, "bodies"):
        assert copy.sites == ideal.sites
        together = np.corrcoef(copy.gyr.ravel(), ideal.gyr.ravel())[0, 1]
        assert 0.9 < together < 0.99999


def test_body_variants_differ_and_other_bodies_are_refused(bundled_body, patches, waving):
    heights = [body_variant(copy, 0).height for copy in range(4)]
    assert len({round(height, 4) for height in heights}) == 4
    assert 1.5 < min(heights) < max(heights) < 1.95
    other = replace(bundled_body, faces=bundled_body.faces[:, [1, 2, 0]])
    with pytest.raises(ValueError, match="leave it out"):
        copies(other, patches, waving, "bodies")


def test_two_clips_do_not_vary_alike(bundled_body, patches, waving):
    other = waving.labelled("waving", "one", "another clip")
    lengths = {
        recording.acc.shape[0]
        for motion in (waving, other)
        for recording in copies(bundled_body, patches, motion, "tempo", number=3)
    }
    assert len(lengths) > 3


def test_an_unknown_switch_is_named():
    some = Augmentation.only(["tempo", "remount"], 2)
    assert (some.tempo > 0, some.remount_deg > 0, some.copies) == (True, True, 2)
    assert (some.mirror, some.bodies, some.noise, some.warp, some.amplitude) == (False, False, False, 0, 0)
    with pytest.raises(ValueError, match="'twist' is no augmentation; there are tempo"):
        Augmentation.only(["tempo", "twist"], 4)
