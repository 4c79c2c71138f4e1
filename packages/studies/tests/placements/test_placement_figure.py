# SPDX-License-Identifier: GPL-3.0-or-later
"""The figure of activities by placement: a cell a score, coloured by it, the same bytes every time."""

import matplotlib.image
import numpy as np
import pytest

from w2w.core.colours import score_colours
from w2w.core.patches.body_parts import PLACEMENTS
from w2w_studies.placements.placement_figure import CELL_HEIGHT, CELL_WIDTH, placement_figure
from w2w_studies.placements.placement_patches import UNUSUAL
from w2w_studies.placements.score_table import ScoreRow

COLUMNS = [placement.name for placement in PLACEMENTS]
COMMON = [name not in UNUSUAL for name in COLUMNS]


def rows(groups, clips=6):
    draw = np.random.default_rng(2)
    found = []
    for group, names in groups.items():
        for name in names:
            f1 = draw.random(len(COLUMNS))
            found.append(ScoreRow(group, name, f1, f1 - 0.1, f1 + 0.1, f1 >= f1.max(), clips, 12))
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    "groups", [{"a": ["x"]}, {"one_group": ["sit", "walk"], "b": ["a very long name" * 4]}]
)
def test_every_cell_has_the_colour_of_its_score(tmp_path, groups):
    made = rows(groups)
    placement_figure(tmp_path / "figure.png", made, COLUMNS, COMMON, "Title")
    image = matplotlib.image.imread(tmp_path / "figure.png")[..., :3]
    colours = score_colours(np.array([row.f1 for row in made]), 0.0, 1.0)
    area = CELL_WIDTH * CELL_HEIGHT * 200**2
    for colour in colours.reshape(-1, 3):
        alike = np.abs(image - colour).max(axis=-1) < 0.02
        assert alike.sum() > 0.4 * area  # less the figures in it
    placement_figure(tmp_path / "again.png", made, COLUMNS, COMMON, "Title")
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "figure.png").read_bytes()


def test_few_clips_are_marked_and_the_picture_grows_with_its_rows(tmp_path):
    sizes = []
    for count, clips in ((2, 6), (4, 6), (4, 2)):
        placement_figure(
            tmp_path / "f.png", rows({"g": "abcd"[:count]}, clips), COLUMNS, COMMON, "A title" * 40
        )
        sizes.append((matplotlib.image.imread(tmp_path / "f.png").shape, (tmp_path / "f.png").read_bytes()))
    assert sizes[1][0][0] - sizes[0][0][0] == pytest.approx(2 * CELL_HEIGHT * 200, abs=1)
    assert sizes[1][0][1] == sizes[0][0][1]
    assert sizes[2][1] != sizes[1][1]
