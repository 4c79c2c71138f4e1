# SPDX-License-Identifier: GPL-3.0-or-later
"""The honest test of several sensors: one classifier on all of them, from what a finished run left."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blender_addon.w2w.core.placement import multi_sensor_check
from blender_addon.w2w.core.utility import UtilityMap

from .finished import FinishedStudy

AT_MOST = 6
"""Sensors that are tested together: the classifier's width grows with each."""


def sensors_together(study: FinishedStudy, order: Sequence[int]) -> tuple[UtilityMap, ...]:
    """Test the first sensor alone, the first two together, and so on, up to `AT_MOST`.

    Parameters
    ----------
    study : FinishedStudy
    order : sequence of int
        Places as chosen.

    Returns
    -------
    tuple of UtilityMap
        Each of one place: the sensors side by side, by the folds of the run and its classifier. Of
        one that takes windows, that is a network of 6 channels a sensor.
    """
    classifier = study.parameters["classifier"]
    windows = [len(found.is_test) for found in study.windows]
    maps = multi_sensor_check(
        order[:AT_MOST],
        study.inputs(classifier),
        np.repeat([clip.activity for clip in study.clips], windows),
        clip=np.repeat([clip.motion for clip in study.clips], windows),
        subject=np.repeat([clip.subject for clip in study.clips], windows)
        if study.parameters["by_subject"]
        else None,
        is_test=np.concatenate([found.is_test for found in study.windows]),
        activities=sorted({clip.activity for clip in study.clips}),
        classifier=classifier,
        folds=study.parameters["folds"],
        seed=study.parameters["seed"],
    )
    return tuple(maps)
