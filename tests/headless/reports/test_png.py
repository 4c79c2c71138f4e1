# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures packed by ourselves, read by Pillow."""

import io

import numpy as np
import pytest
from PIL import Image

from headless.reports.png import write_png


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 7, 3), (40, 3, 3), (200, 310, 3)])
def test_a_picture_comes_back(shape):
    pixels = np.random.default_rng(1).integers(0, 256, shape, dtype=np.uint8)
    pixels[shape[0] // 2 :] = 255
    stream = io.BytesIO()
    write_png(stream, pixels, 200)
    with Image.open(stream) as image:
        assert (image.format, image.mode) == ("PNG", "RGB")
        assert image.info["dpi"] == pytest.approx((200, 200), abs=0.02)
        np.testing.assert_array_equal(np.asarray(image), pixels)
