# SPDX-License-Identifier: GPL-3.0-or-later
"""The three-panel figure: every body on the page once, none over another, the same bytes every time."""

import matplotlib.image
import numpy as np
import pytest
from scipy.ndimage import label

from w2w_studies.rehab.panel_figure import Map, panel_figure

SIZE = 240


def body(*colour):
    """A coloured rectangle as wide as it is tall, on a transparent ground."""
    view = np.zeros((SIZE, SIZE, 4), dtype=np.uint8)
    view[20:220, 20:220] = (*colour, 255)
    return view


def draw(path, count, places=1):
    maps = [
        Map([body(200, 30, 10 + n), body(200, 30, 10 + n)], f"Activity {n}" * 9, "best") for n in range(count)
    ]
    mean, chosen = (
        Map([body(30, 160, 60), body(30, 160, 60)], name, "note " * 60) for name in ("Mean", "Set")
    )
    names = [f"{n} left lower leg lateral, quite near to the ankle" for n in range(places)]
    spots = [(n % 2, 60 + 10 * n, 120) for n in range(places)]
    panel_figure(path, maps, mean, chosen, spots, names, np.linspace(0.6, 0.9, places), (0.2, 0.9), 0.9)
    return matplotlib.image.imread(path)[..., :3]


@pytest.mark.slow
@pytest.mark.parametrize("count", [4, 7])
def test_every_body_stands_apart_from_the_others(tmp_path, count):
    image = draw(tmp_path / "figure.png", count)
    for colour, bodies in (((200, 30), 2 * count), ((30, 160), 4)):
        alike = np.abs(image[..., :2] - np.array(colour) / 255).max(axis=-1) < 0.03
        parts, found = label(alike)
        sizes = np.bincount(parts.ravel())[1:]
        large = sizes[sizes > 0.2 * sizes.max()]
        assert len(large) == bodies, (found, sizes)
        assert large.min() > 0.75 * large.max()  # a badge may cover a little
    edge = 40
    for strip in (image[:edge], image[-edge:], image[:, :edge], image[:, -edge:]):
        assert (strip == 1).all()


def test_the_same_content_gives_the_same_bytes(tmp_path):
    for name in ("one.png", "two.png"):
        draw(tmp_path / name, 4, places=5)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
