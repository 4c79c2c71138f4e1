# SPDX-License-Identifier: GPL-3.0-or-later
"""The report says of straps and tissue what the sensor model holds, and no more."""

import pytest

from w2w.core.imu.presets import preset, wearing_sentences
from w2w.core.imu.sensor import SensorModel


@pytest.mark.parametrize(
    ("model", "text"),
    [
        (SensorModel.ideal(), "Loose straps, soft tissue and clothes are not in it."),
        (preset("bmi270"), "Loose straps, soft tissue and clothes are not in it."),
        (
            preset("watch"),
            "It sits 8° and 5 mm off its place, anew in every clip (one standard deviation), rides on soft "
            "tissue (15 Hz, 50 % of its motion) and loses 0.2 % of its samples. Clothes are not in it.",
        ),
        (
            preset("phone"),
            "It sits 10° and 20 mm off its place, anew in every clip (one standard deviation). "
            "Soft tissue and clothes are not in it.",
        ),
        (
            preset("paper"),
            "It is turned by 5° for good (one standard deviation). "
            "Loose straps, soft tissue and clothes are not in it.",
        ),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_what_is_in_the_model_is_said_and_what_is_not(model, text):
    assert wearing_sentences(model) == text
