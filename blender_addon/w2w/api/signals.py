# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W from Python: motions become signals, and signals a ranking of patches."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, overload

import numpy as np

from ..core.body.body import Body
from ..core.findings.cautions import KNOW, full_scale_sentence
from ..core.imu.presets import DEFAULT_SENSOR
from ..core.imu.recording import ImuRecording
from ..core.imu.sensor import SensorModel
from ..core.imu.synthesis import Synthesis
from ..core.imu.virtual import record_motion
from ..core.library.labels import spelled_once
from ..core.motion.motion import Motion
from ..core.motion.signature import motion_signature
from ..core.patches.naming import resolve
from ..core.patches.patches import PatchSet
from ..core.ranking.classifiers.ridge import Ridge
from ..core.ranking.pooling import Pooling
from ..core.ranking.utility import UtilityMap, inputs_of
from ..core.ranking.weights import check_counting
from ..core.study.choosing import stream_in
from ..core.study.clip_files import ClipWindows
from ..core.study.clip_list import is_used
from ..core.study.config import StudyConfig
from ..core.study.ranking import LabelledClip, WindowLabels, rank_clips, same_motions, stream_of
from ..core.study.results import StudyResults
from ..core.windows.features import window_features
from ..core.windows.windows import TooShortError, WindowSpec, cut_windows
from .loading import Motions, warn_of_spellings
from .notebook import progress_bar, tracked
from .ranking import Ranking


@dataclass(frozen=True, eq=False)
class Signals(Sequence[ImuRecording]):
    """Recordings of a sensor on every patch, one for each motion, with its labels."""

    recordings: tuple[ImuRecording, ...]
    patches: PatchSet
    motions: Motions
    sensor: SensorModel
    settings: Synthesis

    def __repr__(self) -> str:
        return f"<Signals: {len(self)} clips on {len(self.patches)} patches>"

    @overload
    def __getitem__(self, index: int) -> ImuRecording: ...
    @overload
    def __getitem__(self, index: slice) -> Signals: ...
    def __getitem__(self, index: int | slice) -> ImuRecording | Signals:
        if isinstance(index, slice):
            return replace(self, recordings=self.recordings[index], motions=self.motions[index])
        return self.recordings[index]

    def __len__(self) -> int:
        return len(self.recordings)


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
        Seed of the sensors' errors.
    settings : Synthesis, optional
        Everything else about how ideal signals are made; its rate replaces `rate`.
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

    Examples
    --------
    >>> patches = w2w.sample_patches(w2w.Body.bundled(), 24)
    >>> signals = w2w.synthesize(w2w.load("MY_CLIPS"), patches, sensor="bmi270")
    >>> signals[0].acc.shape
    (199, 24, 3)
    """
    if not isinstance(motions, Motions):
        several = (motions,) if isinstance(motions, Motion) else tuple(motions)
        motions = Motions(several, body or Body.bundled(), (), ("",) * len(several))
    if not len(motions) or not all(isinstance(motion, Motion) for motion in motions):
        raise ValueError("there is no motion to record: read some with load")
    if not isinstance(motions.body, Body) or not isinstance(patches, PatchSet):
        raise ValueError("make the patches with sample_patches or patches_at, and the body with load_body")
    if len(patches.labels) != len(motions.body.vertices):
        raise ValueError(
            f"the patches are of a body of {len(patches.labels)} vertices and the motions of one of "
            f"{len(motions.body.vertices)}: sample patches on the motions' body"
        )
    model = sensor if isinstance(sensor, SensorModel) else StudyConfig(sensor=sensor).sensor_model()
    settings = settings or Synthesis(rate_hz=rate)
    if settings.caution:
        warnings.warn(settings.caution, stacklevel=2)
    recordings = tuple(
        record_motion(motions.body, patches, one, settings, model, seed)
        for one in tracked(motions, "Synthesizing signals")
    )
    about = [(one.clip or "a clip", model.full_scale_content(one)) for one in recordings]
    if caution := full_scale_sentence(about):
        warnings.warn(caution, stacklevel=2)
    return Signals(recordings, patches, motions, model, settings)


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

    Activities that cannot be tested are left out; the ranking's `left_out` says why. What stops or weakens
    the answer (the ranking's `cautions`) is warned of.

    Parameters
    ----------
    signals : Signals
        From `synthesize`; their labels are the activities to recognise.
    classifier : str or object
        "ridge", "trees", "multi3net", or one of your own: a scikit-learn estimator, one in an
        `EstimatorClassifier`, or an object with `inputs` and `predict_folds` as `Ridge` has them.
    window, stride : float
        Length of a window and step from one to the next, seconds; half a window by default.
    folds : int
        Folds of the cross-validation by clip.
    by_subject : bool
        Leave one subject out at a time instead.
    seed : int
        Seed of the folds, the bootstrap and the classifier.
    progress : callable, optional
        Given the fraction done; in a notebook it is a bar by default.
    background : sequence of str
        Activities that are trained against and count in no mean.
    weights : mapping of str to float, optional
        Weights of activities in the mean, 1 by default.

    Raises
    ------
    ValueError
        If fewer than two activities can be tested, no clip shows a given activity, or the classifier, the
        windows or the folds are not valid; the message says why.

    Examples
    --------
    >>> signals = w2w.synthesize(w2w.load("MY_CLIPS"), w2w.sample_patches(w2w.Body.bundled(), 24))
    >>> w2w.rank(signals, folds=3).f1.shape
    (24, 3)
    """
    if not isinstance(signals, Signals) or not len(signals):
        raise ValueError("signals must come from synthesize, of one motion at least")
    if isinstance(background, str) or not isinstance(weights or {}, Mapping):
        raise ValueError("background is a list of activities; weights give each a number: {'falling': 3.0}")
    uncounted, weighted = tuple(background), tuple((weights or {}).items())
    labels = {n: {"activity": one.activity, "subject": one.subject} for n, one in enumerate(signals)}
    labels, check = spelled_once(labels)
    warn_of_spellings(check)
    activities = {one["activity"] for one in labels.values()}
    check_counting(activities, uncounted, weighted)
    spec = WindowSpec(window, window / 2 if stride is None else stride)
    config = StudyConfig(
        synthesis=signals.settings,
        sensor=signals.sensor.name,
        own_sensor=signals.sensor,
        windows=spec,
        folds=folds,
        by_subject=by_subject,
        seed=seed,
        background=uncounted,
        weights=weighted,
        classifier=classifier if isinstance(classifier, str) else StudyConfig.classifier,
    )
    as_features = inputs_of(classifier) == "features"
    used, clip_windows, details, inputs, skipped, cut_from = [], [], [], [], [], []
    facts = (*signals.motions.facts, *[{}] * len(signals))[: len(signals)]  # of some nothing may be known
    clips = zip(signals, signals.motions, signals.motions.motion_keys, facts, strict=True)
    for number, (recording, motion, key, of_file) in enumerate(clips):
        name = recording.clip or f"clip {number}"
        try:
            windows = cut_windows(recording, spec)
        except TooShortError as error:
            skipped.append((name, str(error)))
            continue
        cut = windows.signals
        inputs.append(window_features(cut, recording.rate) if as_features else np.array(cut))
        cut_from.append(recording)
        used.append(LabelledClip(name, **labels[number], motion_key=key))
        clip_windows.append(ClipWindows(windows.is_test, motion_signature(motion)))
        about = of_file | {"duration_s": round(motion.duration, 4), "frame_rate": motion.rate}
        about |= signals.sensor.full_scale_content(recording)
        details.append(about | {"windows": len(windows.is_test)})
    if not used:
        raise ValueError(f"every clip is too short for windows of {window:g} s: {skipped[0][1]}")
    whole = np.concatenate(inputs)
    pooling = Pooling.on(signals.motions.body, signals.patches)
    progress = progress or progress_bar("Ranking patches")
    ranked = same_motions(used, clip_windows)
    utility = rank_clips(
        ranked, clip_windows, whole, config, pooling, classifier=classifier, progress=progress
    )
    utility = _with_left_out(utility, activities)
    stream = None
    if classifier == Ridge.name:
        worn = signals.motions.body, signals.patches
        stream = stream_of(ranked, clip_windows, lambda clip, some: cut_from[clip].at(some), config, worn)
    ranking = Ranking(
        utility=utility, patches=signals.patches, body=signals.motions.body, inputs=whole,
        labels=WindowLabels.of(ranked, clip_windows), config=config, classifier=classifier,
        skipped=tuple(skipped), clips=ranked, details=details, stream=stream,
    )  # fmt: skip
    if serious := [caution.sentence() for caution in ranking.cautions if caution.weight != KNOW]:
        warnings.warn(" ".join(serious), stacklevel=2)
    return ranking


def _with_left_out(utility: UtilityMap, activities: Set[str]) -> UtilityMap:
    """The map, with the reason for each of the clips' activities that is not ranked."""
    short = sorted(activities - {*utility.activities, *utility.left_out})
    reasons = {name: f"{name} has only clips that are too short for a window" for name in short}
    return replace(utility, left_out=utility.left_out | reasons)


def open_results(folder: str | Path) -> Ranking:
    """Read the ranking that `w2w run` left in a results folder.

    Parameters
    ----------
    folder : str or Path
        Folder of a finished run.

    Returns
    -------
    Ranking

    Raises
    ------
    ValueError
        If it is not the folder of a finished run; the message says what is missing or unfinished.

    Examples
    --------
    >>> w2w.open_results("RESULTS").names[:2]
    ('right palm', 'left toes')
    """
    study = StudyResults.load(Path(folder))
    config = study.config()
    return Ranking(
        utility=study.utility, patches=study.patches, body=study.body(),
        inputs=study.inputs(config.classifier), labels=study.labels(), config=config,
        classifier=config.classifier, folder=study.out, clips=study.clips,
        details=[entry for entry in study.listed if is_used(entry)], stream=stream_in(study, config),
    )  # fmt: skip


def stream(folder: str | Path, placements: Sequence[str] | None = None) -> Iterator[ImuRecording]:
    """Read the signals of a run's clips, one after another, in memory for one.

    If `w2w run --no-signals` kept none, they are made again from the motions, the same to the last bit.

    Parameters
    ----------
    folder : str or Path
        What `w2w run` left.
    placements : sequence of str, optional
        Places by name, such as "left wrist", or patches; all patches by default.

    Yields
    ------
    ImuRecording
        Of a clip, with its labels; `sites` names the patches.

    Raises
    ------
    ValueError
        If it is not the folder of a finished run, or a name means no place.

    Examples
    --------
    >>> [recording.sites for recording in w2w.stream("RESULTS", ["left toes"])][:1]
    [('left toes',)]
    """
    study = StudyResults.load(Path(folder))
    chosen = None
    if placements is not None:
        chosen = [resolve(name, study.body(), study.patches) for name in placements]
    for clip in range(len(study.clips)):
        yield study.recording(clip, chosen)
