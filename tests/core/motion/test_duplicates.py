# SPDX-License-Identifier: GPL-3.0-or-later
"""Downloads of one motion are known as one, mirrored ones too."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.imu.augmentation import at_tempo, mirrored, scaled
from w2w.core.motion.duplicates import mirrored_signatures, motion_signature
from w2w.core.study import same_clips


def test_the_mirrored_signature_is_that_of_the_mirrored_motion(waving):
    found = mirrored_signatures(motion_signature(waving)[None])[0]
    np.testing.assert_allclose(found, motion_signature(mirrored(waving)), atol=1e-12)
    np.testing.assert_allclose(mirrored_signatures(found[None])[0], motion_signature(waving), atol=1e-12)


def test_a_mirrored_download_is_the_same_motion_and_another_pace_is_not(waving):
    others = [scaled(waving, factor) for factor in (0.2, 1.9)]
    motions = [
        waving,
        *others,
        mirrored(waving),
        replace(waving, pelvis=waving.pelvis + 1.0),
        at_tempo(waving, 2),
    ]
    signatures = np.array([motion_signature(motion) for motion in motions])
    groups = same_clips([f"clip {n}" for n in range(6)], [""] * 6, signatures)
    assert groups.tolist() == [0, 1, 2, 0, 0, 0]


@pytest.mark.parametrize("clips", [1, 2])
def test_few_clips_are_grouped_too(waving, clips):
    signatures = np.array([motion_signature(waving)] * clips)
    assert same_clips([str(n) for n in range(clips)], [""] * clips, signatures).tolist() == [0] * clips
