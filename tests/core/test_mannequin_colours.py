"""A mannequin wears a shirt and shorts, on any body, with hems that are straight."""

import numpy as np
import pytest

from w2w.core.body.regions import regions_of
from w2w.core.body.shapes import shaped
from w2w.core.colours import SHIRT, SHORTS, SKIN, SOFT, mannequin_colours


@pytest.mark.parametrize("shape", [{}, {"gender": -1.0}, {"gender": 1.0, "height": 1.95}])
def test_skin_shirt_and_shorts_are_where_they_belong(bundled_body, shape):
    body = shaped(bundled_body, **shape)
    colours = mannequin_colours(body)
    codes, names = regions_of(body)
    for colour, worn in ((SHIRT, ("sternum", "left shoulder top")), (SHORTS, ("groin",))):
        for name in worn:
            near = colours[codes == names.index(name)]
            np.testing.assert_allclose(near, np.broadcast_to(colour, near.shape), err_msg=name)
    for name in ("nose", "right palm", "left shin", "left toes", "right forearm volar"):
        bare = colours[codes == names.index(name)]
        np.testing.assert_allclose(bare, np.broadcast_to(SKIN, bare.shape), err_msg=name)


def test_the_hem_of_the_shorts_is_level(bundled_body):
    share = mannequin_colours(bundled_body)[:, 0]
    thigh = bundled_body.vertices[:, 2] < bundled_body.joints[0, 2] - 0.1
    hem = thigh & (share > SHORTS[0] + 0.05) & (share < SKIN[0] - 0.05)
    assert hem.sum() > 20
    assert np.ptp(bundled_body.vertices[hem, 2]) <= SOFT
