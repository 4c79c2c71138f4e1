# SPDX-License-Identifier: GPL-3.0-or-later
"""The door for Python: motions in, signals and a ranking of patches out, in a handful of calls."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .core.body.body import Body
from .core.clip_files import ClipWindows
from .core.clip_ranking import LabelledClip, WindowLabels, rank_clips
from .core.imu.presets import DEFAULT_SENSOR
from .core.imu.recording import ImuRecording
from .core.imu.sensor import SensorModel
from .core.imu.synthesis import Synthesis
from .core.imu.virtual import record_motion
from .core.keypoints.facts import PoseFacts
from .core.keypoints.pose_files import NO_FACTS
from .core.motion.bone_maps import BoneMap
from .core.motion.duplicates import motion_signature
from .core.motion.joint_files import is_joint_file
from .core.motion.library import activity_of, read_library
from .core.motion.motion import SMPL_SUFFIXES, Motion
from .core.motion.skinning import on_the_ground
from .core.motion.source import UnusableMotion
from .core.patches.patches import PatchSet
from .core.ranking.features import window_features
from .core.ranking.pooling import Pooling
from .core.ranking.utility import inputs_of
from .core.ranking.weights import check_counting
from .core.ranking.windows import TooShortError, WindowSpec, cut_windows
from .core.results_folder import StudyResults
from .core.study import StudyConfig
from .ranking import Ranking


@dataclass(frozen=True, eq=False)
class Motions(Sequence[Motion]):
    """Motions on one body.

    Parameters
    ----------
    motions : tuple of Motion
    body : Body
        The body that they move.
    skipped : tuple of (str, str)
        Files that could not be used, each with the reason.
    motion_keys : tuple of str
        As in a labels file: equal keys mark one recorded motion; empty where unknown.
    """

    motions: tuple[Motion, ...]
    body: Body
    skipped: tuple[tuple[str, str], ...] = ()
    motion_keys: tuple[str, ...] = ()

    def __getitem__(self, index: int) -> Motion:
        return self.motions[index]

    def __len__(self) -> int:
        return len(self.motions)


@dataclass(frozen=True, eq=False)
class Signals(Sequence[ImuRecording]):
    """What a sensor on every patch records, motion by motion.

    Parameters
    ----------
    recordings : tuple of ImuRecording
        One a motion, with its labels.
    patches : PatchSet
    motions : Motions
        What was recorded.
    """

    recordings: tuple[ImuRecording, ...]
    patches: PatchSet
    motions: Motions

    def __getitem__(self, index: int) -> ImuRecording:
        return self.recordings[index]

    def __len__(self) -> int:
        return len(self.recordings)


def load_body(path: str | Path, betas: Sequence[float] | None = None) -> Body:
    """Read a body: W2W's own npz, or an SMPL model or mesh as `w2w run --bodies` takes.

    Parameters
    ----------
    path : str or Path
    betas : sequence of float, optional
        Shape of an SMPL model.

    Raises
    ------
    ValueError
        If it is no body that W2W can use; the message says why.
    ModuleNotFoundError
        If reading it needs Blender's Python module, which is missing.
    """
    path = Path(path)
    if path.suffix.lower() == ".npz" and betas is None:
        try:
            return Body.load(path)
        except ValueError:
            pass  # an SMPL model is an npz too
    with _needs_blender(path.name):
        from .scene.adopt import adopt_file
    return adopt_file(str(path), None if betas is None else np.asarray(betas, dtype=np.float64))


def load(
    path: str | Path,
    body: Body | None = None,
    labels: str | Path | None = None,
    bone_maps: Sequence[BoneMap] = (),
    pose: PoseFacts = NO_FACTS,
) -> Motions:
    """Read motion files and retarget them to a body.

    FBX, BVH and glTF are read through Blender's Python module (`bpy`), all else without it.

    Parameters
    ----------
    path : str or Path
        A folder of motion files, searched with its subfolders, or one file.
    body : Body, optional
        W2W's own by default.
    labels : str or Path, optional
        A csv with the columns ``file,activity[,subject[,motion_key]]``. By default the labels come from
        the names of the subfolders, else from the file names, as with `w2w run`. One npz that
        `Motion.save` wrote keeps the labels that it holds.
    bone_maps : sequence of BoneMap
        Your own, tried before the bundled ones.
    pose : PoseFacts
        Rate, unit, up axis and joint set of joint positions, where the files do not say them.

    Returns
    -------
    Motions
        A sequence of `Motion`; ``skipped`` lists the files that cannot be used and why.

    Raises
    ------
    ValueError
        If no file can be used; the message says why.
    """
    body = body or Body.bundled()
    path = Path(path)
    if path.is_file():
        motion = _read(path, body, bone_maps, pose)
        if not motion.activity:
            motion = motion.labelled(activity_of(path.name), motion.subject, motion.clip or path.stem)
        return Motions((motion,), body, (), ("",))
    library = read_library(path, labels)
    found, keys, skipped = [], [], list(library.skipped)
    for clip in library.clips:
        try:
            motion = _read(clip.path, body, bone_maps, pose)
        except ValueError as error:
            skipped.append((clip.file, str(error)))
            continue
        found.append(motion.labelled(clip.activity, clip.subject, clip.name))
        keys.append(clip.motion_key)
    if not found:
        file, reason = skipped[0]
        raise ValueError(f"no motion in {path} can be used; {file}: {reason}")
    return Motions(tuple(found), body, tuple(skipped), tuple(keys))


def _read(path: Path, body: Body, bone_maps: Sequence[BoneMap], pose: PoseFacts) -> Motion:
    """One file on the body.

    Raises
    ------
    ValueError
        If it cannot be used, or needs a module that is missing.
    """
    if path.suffix.lower() in SMPL_SUFFIXES and not is_joint_file(path):
        return on_the_ground(body, Motion.load(path))  # which keeps W2W's labels
    from .scene.load import carry, read_motion
    from .scene.output import quiet_output

    try:
        with _needs_blender(path.name), quiet_output():
            source = read_motion(path, pose)
        return carry(source, body, bone_maps).motion
    except UnusableMotion as error:
        raise ValueError(str(error)) from error


@contextmanager
def _needs_blender(file: str) -> Iterator[None]:
    """Say in a sentence where an import fails for want of Blender's module."""
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name not in ("bpy", "mathutils"):
            raise
        raise ValueError(
            f"{file} is read through Blender's Python module, which is missing: in W2W's folder, with "
            "Python 3.11, run pip install '.[blender]'"
        ) from error


def synthesize(
    motions: Motions | Sequence[Motion] | Motion,
    patches: PatchSet,
    sensor: str | SensorModel = DEFAULT_SENSOR,
    rate: float = 50.0,
    seed: int = 0,
    settings: Synthesis | None = None,
    body: Body | None = None,
) -> Signals:
    """Record motions with a virtual IMU on every patch.

    Parameters
    ----------
    motions : Motions, sequence of Motion, or Motion
        From `load`, or your own.
    patches : PatchSet
        Of the same body.
    sensor : str or SensorModel
        A preset's name ("bmi270", see `presets`), "ideal" for no errors, or a model of your own.
    rate : float
        Samples per second.
    seed : int
        Of the sensors' errors.
    settings : Synthesis, optional
        Everything else about how ideal signals are made; `rate` is then its own.
    body : Body, optional
        The body that moves, where `motions` are not from `load`; W2W's own by default.

    Returns
    -------
    Signals
        A sequence of `ImuRecording`: specific force, m/s2, and angular velocity, rad/s, sensor frame.

    Raises
    ------
    ValueError
        If the sensor is unknown, the patches are of another body, or a motion is too short.
    """
    if not isinstance(motions, Motions):
        several = (motions,) if isinstance(motions, Motion) else tuple(motions)
        motions = Motions(several, body or Body.bundled(), (), ("",) * len(several))
    if len(patches.labels) != len(motions.body.vertices):
        raise ValueError(
            f"the patches are of a body of {len(patches.labels)} vertices and the motions of one of "
            f"{len(motions.body.vertices)}: sample patches on the motions' body"
        )
    model = sensor if isinstance(sensor, SensorModel) else StudyConfig(sensor=sensor).sensor_model()
    settings = settings or Synthesis(rate_hz=rate)
    recordings = tuple(
        record_motion(motions.body, patches, motion, settings, model, seed) for motion in motions
    )
    return Signals(recordings, patches, motions)


def rank(
    signals: Signals,
    classifier: Any = "ridge",
    window: float = 2.0,
    stride: float | None = None,
    folds: int = 5,
    by_subject: bool = False,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    background: Sequence[str] = (),
    weights: Mapping[str, float] | None = None,
) -> Ranking:
    """Train and test a classifier on every patch alone, never on the same clip.

    Parameters
    ----------
    signals : Signals
        From `synthesize`; their labels are what is recognised.
    classifier : str or object
        "ridge", "trees", "multi3net", or a classifier of your own: an `EstimatorClassifier` around any
        scikit-learn estimator, or an object with `inputs` and `predict_folds` as `Ridge` has them.
    window, stride : float
        Length of a window and step from one to the next, seconds; half a window by default.
    folds : int
        Folds of the cross-validation by clip.
    by_subject : bool
        Leave one subject out at a time instead.
    seed : int
        Of the folds, the bootstrap and the classifier.
    progress : callable, optional
        Given the fraction done.
    background : sequence of str
        Activities that are trained against and count in no mean.
    weights : mapping of str to float, optional
        What activities count in the mean, 1 by default.

    Raises
    ------
    ValueError
        If fewer than two activities can be tested, or an activity given is no clip's; the message says why.
    """
    counted = tuple(background), tuple((weights or {}).items())
    check_counting({recording.activity for recording in signals}, *counted)
    spec = WindowSpec(window, window / 2 if stride is None else stride)
    kind = inputs_of(classifier)
    used, found, inputs, skipped = [], [], [], []
    for number, (recording, motion) in enumerate(zip(signals, signals.motions, strict=True)):
        name = recording.clip or f"clip {number}"
        try:
            windows = cut_windows(recording, spec)
        except TooShortError as error:
            skipped.append((name, str(error)))
            continue
        as_features = kind == "features"
        inputs.append(
            window_features(windows.signals, recording.rate) if as_features else np.array(windows.signals)
        )
        key = signals.motions.motion_keys[number]
        used.append(LabelledClip(name, recording.activity, recording.subject, key))
        found.append(ClipWindows(windows.is_test, motion_signature(motion), (len(windows.is_test),)))
    if not used:
        raise ValueError(f"every clip is too short for windows of {window:g} s: {skipped[0][1]}")
    config = StudyConfig(
        windows=spec, folds=folds, by_subject=by_subject, seed=seed, background=counted[0], weights=counted[1]
    )
    whole = np.concatenate(inputs)
    pooling = Pooling.on(signals.motions.body, signals.patches)
    utility, ranked = rank_clips(used, found, whole, config, progress, None, classifier, pooling)
    labels = WindowLabels.of(ranked, found)
    return Ranking(
        utility, signals.patches, signals.motions.body, whole, labels, config, classifier, tuple(skipped)
    )


def open_results(folder: str | Path) -> Ranking:
    """The ranking that `w2w run` left in a results folder.

    Raises
    ------
    ValueError
        If it is not the folder of a finished run; the message says what is missing.
    """
    study = StudyResults.load(Path(folder))
    config = study.config()
    return Ranking(
        study.utility,
        study.patches,
        study.body(),
        study.inputs(config.classifier),
        study.labels(),
        config,
        config.classifier,
    )
