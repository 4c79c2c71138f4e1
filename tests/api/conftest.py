# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions of three activities, their signals on 24 patches and their ranking."""

import pytest

import w2w

from ..headless.conftest import all_orders, few_orders, made_once_here
from ..here import ranked_roughly

__all__ = ["all_orders", "few_orders", "made_once_here"]


@pytest.fixture(scope="package")
def library(door):
    return door / "MY_CLIPS"


@pytest.fixture(scope="package")
def few():
    return w2w.sample_patches(w2w.Body.bundled(), 24)


@pytest.fixture(scope="package")
def signals(library, few):
    return w2w.synthesize(w2w.load(library, labels=library.parent / "labels.csv"), few, sensor="bmi270")


@pytest.fixture(scope="package")
def ranking(signals):
    with ranked_roughly():
        return w2w.rank(signals, folds=3)
