# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W from Python: signals, simulated or of worn sensors, become a ranking of places."""

import warnings
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..core.findings.cautions import KNOW, LACKS
from ..core.imu.recording import ImuRecording
from ..core.imu.recordings import Recordings
from ..core.imu.synthesis import Synthesis
from ..core.library.labels import spelled_once
from ..core.motion.motion import Motion
from ..core.motion.signature import motion_signature
from ..core.patches.patches import unplaced
from ..core.ranking.classifiers.ridge import Ridge
from ..core.ranking.pooling import Pooling
from ..core.ranking.utility import UtilityMap, inputs_of
from ..core.ranking.weights import check_counting
from ..core.study.clip_files import NO_SIGNATURE, ClipWindows
from ..core.study.config import StudyConfig
from ..core.study.ranking import LabelledClip, WindowLabels, rank_clips, same_motions, stream_of
from ..core.windows.inputs import cut_recordings
from ..core.windows.windows import WindowSpec
from ..core.wording import join_words
from .loading import warn_of_spellings
from .notebook import progress_bar
from .ranking import Ranking
from .signals import Signals


class _Clips(NamedTuple):
    """Clips to rank, one after another in `inputs`."""

    ranked: tuple[LabelledClip, ...]
    windows: list[ClipWindows]
    inputs: list[np.ndarray]
    details: list[dict[str, Any]]
    recordings: list[ImuRecording]  # those with windows, in the order of `inputs`
    skipped: list[tuple[str, str]]
    motions: tuple[Motion, ...] = ()


Labels = Mapping[int, Mapping[str, str]]


def rank(
    signals: Signals | Recordings,
    classifier: Any = "ridge",
    window: float = 2.0,
    stride: float | None = None,
    folds: int = 5,
    by_subject: bool = False,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    background: Sequence[str] = (),
    weights: Mapping[str, float] | None = None,
    habit: str = StudyConfig.habit,
) -> Ranking:
    """Train and test a classifier on every patch alone, never on the same clip.

    Activities that cannot be tested are left out; the ranking's `left_out` says why. What stops or weakens
    the answer (the ranking's `cautions`) is warned of.

    Parameters
    ----------
    signals : Signals or Recordings
        From `synthesize`, or of worn sensors; their labels are the activities to recognise. Places of worn
        sensors are compared on the same clips: those that lack a sensor are skipped.
    classifier : str or object
        "ridge", "trees", "multi3net", or one of your own: a scikit-learn estimator, one in an
        `EstimatorClassifier`, or an object with `inputs` and `predict_folds` as `Ridge` has them.
    window, stride : float
        Length of a window and step from one to the next, seconds; half a window by default.
    folds : int
        Folds of the cross-validation by clip.
    by_subject : bool
        Leave one subject out at a time instead: F1 is then on other people.
    seed : int
        Seed of the folds, the bootstrap and the classifier.
    progress : callable, optional
        Given the fraction done; in a notebook it is a bar by default.
    background : sequence of str
        Activities that are trained against and count in no mean.
    weights : mapping of str to float, optional
        Weights of activities in the mean, 1 by default.
    habit : str
        Product that people wear anyway: the answer keeps it unless another does better.

    Returns
    -------
    Ranking
        Every place's F1, the answer and what can be asked of it.

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
    if not isinstance(signals, Signals | Recordings) or not len(signals):
        raise ValueError("rank takes what synthesize makes, or Recordings of worn sensors: one clip at least")
    if progress is not None and not callable(progress):
        raise ValueError("progress is a function that is given the fraction done, such as print")
    if not isinstance(background, list | tuple | set) or not isinstance(weights or {}, Mapping):
        raise ValueError("background is a list of activities; weights give each a number: {'falling': 3.0}")
    uncounted, weighted = tuple(background), tuple((weights or {}).items())
    labels = {n: {"activity": one.activity, "subject": one.subject} for n, one in enumerate(signals)}
    labels, check = spelled_once(labels)
    warn_of_spellings(check)
    activities = {one["activity"] for one in labels.values()}
    if not any(activities):
        raise ValueError(
            "no motion says its activity: label them, as by motion.labelled('walking', 'S01', 'clip 1')"
        )
    check_counting(activities, uncounted, weighted)
    try:
        spec = WindowSpec.of_length(window, stride)
    except ValueError as error:
        raise ValueError(str(error).replace("length_s", "window").replace("stride_s", "stride")) from None
    if isinstance(signals, Signals):
        made = signals.config
    else:
        made = StudyConfig(synthesis=Synthesis(rate_hz=signals.rate), sensor="ideal")
    config = replace(
        made,
        windows=spec,
        folds=folds,
        by_subject=by_subject,
        seed=seed,
        background=uncounted,
        weights=weighted,
        habit=habit,
        classifier=classifier if isinstance(classifier, str) else StudyConfig.classifier,
    )
    kind, body = inputs_of(classifier), None
    if isinstance(signals, Signals):
        clips, patches, body = _simulated(signals, labels, spec, kind), signals.patches, signals.motions.body
    else:
        clips, patches = _worn(signals, labels, spec, kind), unplaced(signals.places)
    if not clips.inputs:
        raise ValueError(f"no clip gives a window of {window:g} s: {clips.skipped[0][1]}")
    whole, what = np.concatenate(clips.inputs), "Ranking patches" if body else "Ranking places"
    utility = rank_clips(
        clips.ranked, clips.windows, whole, config, Pooling.on(body, patches),
        classifier=classifier, progress=progress or progress_bar(what),
    )  # fmt: skip
    stream, recordings = None, clips.recordings
    if classifier == Ridge.name and body is not None:
        worn = body, patches
        stream = stream_of(
            clips.ranked,
            clips.windows,
            lambda numbers, some: [recordings[number].at(some) for number in numbers],
            config,
            worn,
        )
        utility = stream.on_map(utility)
    ranking = Ranking(
        utility=_with_left_out(utility, activities), patches=patches, body=body, inputs=whole,
        labels=WindowLabels.of(clips.ranked, clips.windows), config=config, classifier=classifier,
        skipped=tuple(clips.skipped), clips=clips.ranked, details=clips.details, stream=stream,
        recordings=Recordings(recordings) if isinstance(signals, Recordings) else None, motions=clips.motions,
    )  # fmt: skip
    if serious := [caution.sentence() for caution in ranking.cautions if caution.weight != KNOW]:
        warnings.warn(" ".join(serious), stacklevel=2)
    return ranking


def _simulated(signals: Signals, labels: Labels, spec: WindowSpec, inputs: str) -> _Clips:
    cut = cut_recordings(signals, spec, inputs)
    names = [one.clip or f"clip {number}" for number, one in enumerate(signals)]
    facts = (*signals.motions.facts, *[{}] * len(signals))  # of some nothing may be known
    used, windows, details = [], [], []
    for number, is_test in zip(cut.used, cut.is_test, strict=True):
        motion, recording = signals.motions[number], signals[number]
        used.append(
            LabelledClip(names[number], **labels[number], motion_key=signals.motions.motion_keys[number])
        )
        windows.append(ClipWindows(is_test, motion_signature(motion)))
        about = facts[number] | {"duration_s": round(motion.duration, 4), "frame_rate": motion.rate}
        about |= signals.config.sensor_model().full_scale_content(recording)
        details.append(about | {"windows": len(is_test)})
    skipped = [(names[number], why) for number, why in cut.skipped.items()]
    return _Clips(
        same_motions(used, windows), windows, cut.inputs, details, [signals[n] for n in cut.used], skipped,
        tuple(signals.motions[n] for n in cut.used),
    )  # fmt: skip


def _worn(recordings: Recordings, labels: Labels, spec: WindowSpec, inputs: str) -> _Clips:
    lacking = recordings.lacking()
    whole = [number for number, one in enumerate(recordings) if one.clip not in lacking]
    cut = cut_recordings([recordings[number] for number in whole], spec, inputs)
    stretches: dict[str, list[tuple[int, np.ndarray, np.ndarray]]] = {}  # of each clip
    for position, is_test, block in zip(cut.used, cut.is_test, cut.inputs, strict=True):
        number = whole[position]
        stretches.setdefault(recordings[number].clip, []).append((number, is_test, block))
    used, windows, details = [], [], []
    for clip, some in stretches.items():
        numbers, tests, _ = zip(*some, strict=True)
        used.append(LabelledClip(clip, **labels[numbers[0]], motion_key=clip))
        windows.append(ClipWindows(np.concatenate(tests), NO_SIGNATURE))
        seconds = round(float(np.median([recordings[n].n_samples / recordings.rate for n in numbers])), 4)
        about = {"duration_s": seconds, "frame_rate": recordings.rate}
        details.append(about | {"windows": len(windows[-1].is_test)})
    every = [stretch for some in stretches.values() for stretch in some]
    skipped = [(recordings[whole[number]].clip, why) for number, why in cut.skipped.items()]
    skipped += [(clip, f"{LACKS} {join_words(places)}") for clip, places in lacking.items()]
    return _Clips(
        tuple(used), windows, [block for *_, block in every], details,
        [recordings[number] for number, *_ in every], [*recordings.skipped, *skipped],
    )  # fmt: skip


def _with_left_out(utility: UtilityMap, activities: Set[str]) -> UtilityMap:
    """The map, with the reason for each of the clips' activities that is not ranked."""
    short = sorted(activities - {*utility.activities, *utility.left_out})
    reasons = {name: f"{name} has only clips that are too short for a window" for name in short}
    return replace(utility, left_out=utility.left_out | reasons)
