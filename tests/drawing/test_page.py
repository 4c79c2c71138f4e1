# SPDX-License-Identifier: GPL-3.0-or-later
"""A user's words on every kind of figure: what looks like a formula is written as it stands."""

from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from w2w.core.body.body import Body
from w2w.core.colours import Scale
from w2w.core.imu.recording import ImuRecording
from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w.core.study.config import StudyConfig
from w2w.drawing import heatmap, signal_figure
from w2w.drawing.page import SensorList, shaped
from w2w_studies.comparisons import figures
from w2w_studies.placements import placement_figure
from w2w_studies.placements.score_table import ScoreRow
from w2w_studies.rehab import panel_figure
from w2w_studies.sweep.cases import Case
from w2w_studies.sweep.figure import sweep_figure
from w2w_studies.sweep.report import SweptCase
from w2w_studies.sweep.sensitivity import compare_maps

from ..rings import by_day

HOSTILE = [r"$\frac{$", r"a $5 and b $\unknown{x}$", "$$", "^_{}\\ % & # ~", "<b>{0}%s"]
VIEW = np.full((60, 40, 4), 255, dtype=np.uint8)
SIX = np.linspace(0.2, 0.9, 6)


def _heatmap(path, name):
    heatmap.heatmap_figure(path, [VIEW, VIEW], name, Scale(0.2, 0.9, name, name), name)


def _subset(path, name):
    markers = [(0, 20, 30), (1, 20, 30)]
    scale, names = Scale(0.2, 0.9, name, name), [name, name]
    sensors = SensorList(names, [0.5, 0.6], names, 0.9)
    heatmap.subset_figure(path, [VIEW, VIEW], name, scale, markers, sensors, name)


def _panel(path, name):
    one = panel_figure.Map([VIEW, VIEW], name, name)
    panel_figure.panel_figure(path, [one], one, one, [(0, 20, 30)], [name], [0.6], (0.2, 0.9), 0.9)


def _placement(path, name):
    row = ScoreRow(name, name, SIX[:2], SIX[:2], SIX[:2], SIX[:2] > 1, 6, 12)
    placement_figure.placement_figure(path, [row], [name, "b"], [name, "b"], name)


def _signal(path, name):
    recording = ImuRecording(np.ones((9, 1, 3)), np.ones((9, 1, 3)), 30.0, (name,), name, name, name)
    signal_figure.signal_figure(path, recording, name, name)


def _sweep(path, name):
    clip = np.arange(72) // 3
    features = np.random.default_rng(0).normal(size=(72, 6, 4)).astype(np.float32)
    activity = np.repeat(["bow", "jump"], 36)
    utility = utility_map(
        features,
        CrossValidation(activity, clip, None, np.ones(72, bool), ("bow", "jump")),
        Ridge(alphas=(0.1,)),
        resamples=9,
    )
    one = SweptCase(Case("usual", name, StudyConfig()), utility, compare_maps(utility, utility))
    sweep_figure(path, [one], sample_patches(Body.bundled(), 6))


def _confusions(path, name):
    figures.confusions_figure(path, {name: np.eye(2)}, [name, "b"], name)


def _score_maps(path, name):
    side = SimpleNamespace(activities=[name, "b"], f1=np.full((2, 2), 0.5), mean=np.full(2, 0.5))
    figures.score_maps_figure(path, SimpleNamespace(real=side, simulated=side, sites=(name, "wrist")), name)


def _drawing(path, name):
    patches = sample_patches(Body.bundled(), 6)
    heatmap.draw_heatmap(path, Body.bundled(), patches, SIX, name, Scale.of(SIX, title=name), name)


KINDS = [_heatmap, _subset, _panel, _placement, _signal, _sweep, _confusions, _score_maps, _drawing]


@pytest.mark.later
@pytest.mark.parametrize("kind", by_day((_heatmap, _subset, _signal), KINDS))
def test_a_name_that_looks_like_a_formula_is_drawn_as_it_stands(kind, tmp_path):
    for number, name in enumerate(HOSTILE if kind is _heatmap else HOSTILE[:1]):
        kind(tmp_path / f"{number}.png", name)
        assert (tmp_path / f"{number}.png").stat().st_size > 0


@pytest.mark.parametrize("size", [(300, 400), (900, 100)])
@pytest.mark.parametrize(("shape", "ratio"), [("WIDE", 16 / 9), ("SQUARE", 1.0)])
def test_a_picture_gets_room_around_it_and_loses_nothing(size, shape, ratio):
    pixels = np.array(shaped(Image.new("RGBA", size, "#ff0000ff"), shape, "#ffffff00"))
    height, width, _ = pixels.shape
    assert width / height == pytest.approx(ratio, abs=0.01)
    shown = pixels[..., 3] > 0
    assert shown.sum() == size[0] * size[1]
    assert (pixels[shown] == (255, 0, 0, 255)).all()
