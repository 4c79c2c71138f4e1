# SPDX-License-Identifier: GPL-3.0-or-later
"""Segments: they share the skin out, and per cents are those of a tape."""

import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.body.shapes import shaped
from w2w.core.patches.tape_segments import SEGMENT_NAMES, _outline, segments_of

from ...rings import by_day

SHAPES = [{}, {"height": 1.4}, {"gender": 1.0, "height": 2.1, "weight": 130.0}]


@pytest.mark.parametrize("shape", by_day(SHAPES[::2], SHAPES))
def test_segments_share_the_skin_out(bundled_body, shape):
    body = shaped(bundled_body, **shape)
    found = segments_of(body)
    assert tuple(found) == SEGMENT_NAMES
    members = np.concatenate([segment.vertices for segment in found.values()])
    assert sorted(members.tolist()) == list(range(len(body.vertices)))
    assert all(segment.length > 0 for segment in found.values())


def test_per_cents_around_a_round_and_a_flat_outline_are_those_of_a_tape():
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    for depth, width in ((0.1, 0.1), (0.1, 0.2)):
        ring = np.stack([depth * np.cos(angles), width * np.sin(angles)], axis=1)
        ends = np.stack([np.insert(ring, 0, height, axis=1) for height in (-0.01, 0.01)], axis=1)
        girth, shares = _outline(ends, 0.0)
        exact = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1).sum()
        assert girth == pytest.approx(exact, rel=1e-3)
        np.testing.assert_allclose(shares[[0, 60, 120, 180, 240]], [0, 0.25, 0.5, 0.75, 1], atol=1e-3)
    assert _outline(ends + [0, 1.0, 0], 0.0) is None


@pytest.mark.slow
def test_a_body_of_another_mesh_has_the_same_segments(bundled_body):
    """One whose landmarks are looked for anew, for its triangles are in another order."""
    other = Body(bundled_body.vertices, bundled_body.faces[::-1], bundled_body.joints, bundled_body.weights)
    for name, segment in segments_of(other).items():
        assert segment.length == pytest.approx(segments_of(bundled_body)[name].length, rel=0.02)
