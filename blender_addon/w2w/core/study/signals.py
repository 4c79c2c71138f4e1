# SPDX-License-Identifier: GPL-3.0-or-later
"""A study's steps from a body and a motion to windows: patches, signals, features."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..body.body import Body
from ..imu.cover import ClothSensors
from ..imu.recording import ImuRecording
from ..imu.synthesis import synthesize
from ..imu.virtual import further_signals, record_motion
from ..motion.motion import Motion, low_passed, smoothed_root
from ..patches.own_placements import with_placements
from ..patches.patches import PatchSet, sample_patches
from ..threads import unthreaded_products
from ..windows.features import further_features, window_features
from ..windows.windows import cut_windows
from .config import StudyConfig

SIGNALS_VERSION = 2
"""Version of motions on the body, signals and features: raise it with a change that gives others."""


@unthreaded_products()
def place_patches(body: Body, config: StudyConfig) -> PatchSet:
    """The study's patches on its body, then the user's placements.

    Raises
    ------
    ValueError
        If a placement is not possible; the message says why.
    """
    patches = sample_patches(body, config.patches, config.seed)
    return with_placements(body, patches, dict(config.placements)) if config.placements else patches


def simulate(
    body: Body,
    patches: PatchSet,
    motion: Motion,
    config: StudyConfig,
    on_cloth: ClothSensors | None = None,
    chosen: Sequence[int] | None = None,
) -> ImuRecording:
    """Recording of sensors on all patches, or the `chosen`, through one motion.

    `on_cloth` is how all those on cloth move. ValueError if the motion is too short for the synthesis.
    """
    motion, sensor = measured(motion, config), config.sensor_model()
    if on_cloth is None:
        return record_motion(
            body, patches, motion, config.synthesis, sensor, config.seed, config.further, chosen
        )
    ideal = record_motion(body, patches, motion, config.synthesis)
    return sensor.apply(on_cloth.over(ideal, config.synthesis), seed=config.seed)


def measured(motion: Motion, config: StudyConfig) -> Motion:
    """The motion with its root's path band-limited, if the config asks for it and the frames hold more."""
    if config.root_band_hz is None or config.root_band_hz >= motion.rate / 2:
        return motion
    return smoothed_root(motion, config.root_band_hz)


def record_baked(
    matrices: np.ndarray,
    rate: float,
    patches: PatchSet,
    labels: tuple[str, str, str],
    config: StudyConfig,
    root: np.ndarray | None = None,
    on_cloth: ClothSensors | None = None,
    sensors: Sequence[int] | None = None,
) -> ImuRecording:
    """Recording of sensors on all patches of a surface that Blender has moved.

    `matrices`, shape (T, N, 4, 4), are the patches' in the world, `labels` activity, subject and clip.
    `sensors` are the patches' numbers if they are a part of a larger set. `root`, shape (T, 3), is the path
    of the body's root in the world. ValueError if it is to be band-limited and not known, or if the motion is
    too short for the synthesis.
    """
    if config.root_band_hz is not None and config.root_band_hz < rate / 2:
        if root is None or on_cloth is not None:
            raise ValueError("its root cannot be told from its surface: set the root band to 0")
        matrices = matrices.copy()
        matrices[..., :3, 3] += (low_passed(root, rate, config.root_band_hz) - root)[:, None]
    ideal = synthesize(matrices, rate, config.synthesis)
    if on_cloth is not None:
        ideal = on_cloth.over(ideal, config.synthesis)
    named, sensor = ideal.labelled(patches.names, *labels), config.sensor_model()
    further: Mapping[str, Any] = further_signals(
        matrices, rate, config.synthesis, sensor, config.further, named.clip, config.seed, sensors
    )
    return replace(sensor.apply(named, config.seed, sensors), **further)


def describe(recording: ImuRecording, config: StudyConfig) -> tuple[np.ndarray, np.ndarray]:
    """Windows of a recording as features, shape (W, N, D), float32, and the mask (W,) of test windows.

    Test windows do not overlap. TooShortError if the recording does not fill one window.
    """
    windows = cut_windows(recording, config.windows)
    features = window_features(windows.signals, recording.rate)
    if config.further.features:
        others = further_features(recording, config.windows, config.further.features)
        features = np.concatenate([features, others], axis=2)
    return features, windows.is_test
