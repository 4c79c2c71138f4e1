# SPDX-License-Identifier: GPL-3.0-or-later
"""The utility map: cross-validated F1 of every patch and activity, and how sure it is."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from ..files import load_arrays, write_npz
from ..threads import Spread
from ..windows.inputs import PatchBlocks, SomeWindows, as_blocks
from .classifiers.estimator import Classifier, own
from .classifiers.ridge import Ridge
from .expected import SURE, expect, most_shown
from .f1 import FEWEST_CLIPS, confusion_of, score_patches, try_all
from .folds import SUBJECT_OUT
from .halves import HALVINGS, CrossValidation, Plan, TrialPlan
from .pooling import Pooling
from .weights import alike, mean_over

PLUG_INS = "w2w.classifiers"
"""Entry points of packages that bring classifiers and the libraries these need: W2W's own from pip does."""

CLASSIFIERS: dict[str, EntryPoint | None] = {
    "ridge": None,
    **{point.name: point for point in sorted(entry_points(group=PLUG_INS))},
}
"""Each makes a `Classifier` from a `seed`."""

LEVEL = 0.95
"""Confidence of the intervals."""

OPTIONAL = ("trial_f1", "weights", "errors", "lost", "posture")
"""Fields that a file may lack: `trial_f1` where nothing was halved, `weights` where all count alike."""


class ExpectedF1(NamedTuple):
    """Macro F1 expected on other clips, and its interval: of one place, or of many (N,)."""

    mean: Any
    low: Any
    high: Any

    def at(self, patch: int) -> "ExpectedF1":
        """That of one patch."""
        return ExpectedF1(*(float(values[patch]) for values in self))


@dataclass(frozen=True, eq=False)
class UtilityMap:
    """F1 by patch and activity, cross-validated without sharing a clip.

    Attributes
    ----------
    activities : tuple of str, length A
        The activities tested; columns of `f1`.
    f1, f1_low, f1_high : ndarray, shape (N, A), float32
        F1 over all test windows, and its interval.
    mean_low, mean_high : ndarray, shape (N,), float32
        Interval of the macro F1 `mean`.
    rank_low, rank_high : ndarray, shape (N,), int
        Interval of the patch's rank by mean F1 among all patches; 1 is the best.
    mean_samples : ndarray, shape (B, N), float32
        Macro F1 of each bootstrap resample of the clips, for comparing patches pairwise.
    expected_f1 : ndarray, shape (N, A), float32
        F1 that other clips would show (`expected.expect`).
    expected_mean, expected_low, expected_high : ndarray, shape (N,), float32
        Macro F1 that other clips would show, and its interval.
    reliability : float
        Correlation over patches of the macro F1 itself with that on as many other clips
        (`expected.clips_needed` says how many more clips it takes); NaN where it is not known.
    beats_average : float
        Chance that the patch of highest `expected_mean` scores above an average patch on other clips.
    predictions : ndarray, shape (W_test, N), int16
        Activity that each patch predicts for each test window.
    truth : ndarray, shape (W_test,), int16
    clip : ndarray of str, shape (W_test,)
    level : float
        Confidence of the intervals.
    classifier, protocol : str
        What was trained and how it was split.
    left_out : dict of str to str
        Activities not tested, each with the reason.
    weights : ndarray, shape (A,), optional
        What each activity counts in every mean over activities, 0 for background; 1 each by default.
    errors : ndarray, shape (E, N), float32
        Errors of `expected_mean` against as many other clips, but for the level that all patches share, as
        halves of the clips show them; no rows where nothing was halved.
    trial_f1 : ndarray, shape (T, A, N), or None
        F1 by window in each trial of the plan: of all clips, then of their halves (or single subjects), by
        which sets are chosen and the map is weighed anew; None without these.
    lost : ndarray, shape (A,), or None
        What was taken off the F1 expected of one sensor, as it is lost where clips follow one another.
    posture : ndarray, shape (N, A), or None
        What is left of `expected_f1` if a sensor tells the direction of gravity alone; NaN where no product
        sits.

    Examples
    --------
    >>> w2w.open_results("RESULTS").utility
    <UtilityMap: 24 patches, 3 activities, ridge>
    """

    activities: tuple[str, ...]
    f1: np.ndarray
    f1_low: np.ndarray
    f1_high: np.ndarray
    mean_low: np.ndarray
    mean_high: np.ndarray
    rank_low: np.ndarray
    rank_high: np.ndarray
    mean_samples: np.ndarray
    expected_f1: np.ndarray
    expected_mean: np.ndarray
    expected_low: np.ndarray
    expected_high: np.ndarray
    reliability: float
    beats_average: float
    predictions: np.ndarray
    truth: np.ndarray
    clip: np.ndarray
    level: float
    classifier: str
    protocol: str
    left_out: dict[str, str]
    weights: np.ndarray = field(default_factory=lambda: np.empty(0))
    errors: np.ndarray = field(default_factory=lambda: np.empty((0, 0), dtype=np.float32))
    trial_f1: np.ndarray | None = None
    lost: np.ndarray | None = None
    posture: np.ndarray | None = None

    def __repr__(self) -> str:
        n_patches, n_activities = self.f1.shape
        return f"<UtilityMap: {n_patches} patches, {n_activities} activities, {self.classifier}>"

    def __post_init__(self) -> None:
        if not len(self.weights):
            object.__setattr__(self, "weights", np.ones(len(self.activities)))

    @cached_property
    def mean(self) -> np.ndarray:
        """Macro F1, shape (N,), float32: the mean over activities."""
        return mean_over(self.f1, self.weights)

    @cached_property
    def confusion(self) -> np.ndarray:
        """Windows by actual activity (rows) and predicted activity (columns), shape (N, A, A), int32."""
        return confusion_of(self.truth, self.predictions, len(self.activities))

    @property
    def counts(self) -> np.ndarray:
        """Activities that count, shape (A,), bool: all but background."""
        return self.weights > 0

    @property
    def expected(self) -> ExpectedF1:
        """Expected macro F1 of each patch, shape (N,)."""
        return ExpectedF1(self.expected_mean, self.expected_low, self.expected_high)

    @property
    def can_rank(self) -> bool:
        """Whether the best patch is sure to beat an average one on other clips."""
        return self.beats_average >= SURE

    @property
    def halved(self) -> bool:
        """Whether halves of the clips tell how far the map repeats."""
        return len(self.errors) > 0

    @property
    def by_subject(self) -> bool:
        """Whether subjects were left out, so that the map is about other people."""
        return self.protocol.startswith(SUBJECT_OUT)

    @property
    def doubtful(self) -> bool:
        """Whether halves say too little of errors: of people, or with few clips of most activities."""
        return self.by_subject or self.few or not self.halved

    @property
    def few(self) -> bool:
        """Whether the library is small: half of the activities have too few clips for an interval."""
        return float(np.median(self.tested_clips())) < FEWEST_CLIPS

    def tested_clips(self) -> tuple[int, ...]:
        """Distinct clips that each activity was tested on."""
        return tuple(len(np.unique(self.clip[self.truth == a])) for a in range(len(self.activities)))

    def trials_of(self, plan: Plan) -> np.ndarray | None:
        """`trial_f1`, if there is one of just this plan."""
        f1, shape = self.trial_f1, (len(plan.trials), *self.f1.T.shape)
        return f1 if f1 is not None and (f1.shape, f1.dtype) == (shape, np.float64) else None

    def save(self, path: str | Path) -> None:
        """Write an npz that `load` reads."""
        arrays: dict[str, Any] = {each.name: getattr(self, each.name) for each in fields(self)}
        arrays["activities"] = np.array(self.activities, dtype=np.str_)
        arrays["left_out"] = np.array(json.dumps(self.left_out, ensure_ascii=False))
        if alike(self.weights):
            arrays["weights"] = None
        write_npz(path, {name: array for name, array in arrays.items() if array is not None}, compress=True)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a file that `save` wrote; a ValueError if it is not a utility map."""
        names = [each.name for each in fields(cls) if each.name not in OPTIONAL]
        arrays = load_arrays(path, names, "is not a utility map", OPTIONAL)
        content: dict[str, Any] = {
            name: values if values.ndim else values.item() for name, values in arrays.items()
        }
        content["activities"] = tuple(content["activities"].tolist())
        content["left_out"] = json.loads(content["left_out"])
        return cls(**content)


def utility_map(
    inputs: np.ndarray | PatchBlocks,
    protocol: CrossValidation,
    classifier: Any = "ridge",
    *,
    resamples: int = 500,
    progress: Callable[[float], None] | None = None,
    work: Path | None = None,
    pooling: Pooling | None = None,
    halvings: int = HALVINGS,
    spread: Spread | None = None,
) -> UtilityMap:
    """Train and test a classifier at every patch, never on the same clip.

    Parameters
    ----------
    inputs : ndarray or PatchBlocks, shape (W, N, ...)
        What the classifier takes (`inputs_of`): features (W, N, D), or windows (W, N, samples, 6);
        in memory, or served some patches at a time.
    protocol : CrossValidation
    classifier : str or object
        Name in CLASSIFIERS, or an object with `predict_folds` like theirs.
    resamples : int
        Bootstrap resamples of the clips.
    progress : callable, optional
        Given the fraction done.
    work : Path, optional
        Folder in which a classifier given by name that takes long leaves what a later
        call with the same inputs takes up.
    pooling : Pooling, optional
        Over the skin of the body that the patches are on, for the expected scores.
    halvings : int
        Ways in which the clips are halved for them; 0 for none.
    spread : callable, optional
        Runs the trials of some patches at a time elsewhere, such as on a cluster, if the classifier can.

    Raises
    ------
    ValueError
        If fewer than two activities can be tested, or none of them counts; the message says why.
    """
    model = _model(classifier, protocol.seed, work)
    planned = protocol.plan(halvings if isinstance(model, Ridge) else 0)
    source = SomeWindows(as_blocks(inputs), planned.used)
    tried: tuple[np.ndarray, np.ndarray | None]
    if isinstance(model, Ridge):
        tried = try_all(model, source, planned, progress, spread)
    else:
        tried = model.predict_folds(source, planned.labels, planned.fold, planned.is_test, progress), None
    pooling = pooling or Pooling.none(source.shape[1])
    return _map_of(tried, (protocol, planned), pooling, resamples, model.name)


def weighed(utility: UtilityMap, protocol: CrossValidation, pooling: Pooling) -> UtilityMap | None:
    """A map as its protocol with other weights gives it, without training; None if it has no trials."""
    planned, resamples = protocol.plan(), len(utility.mean_samples)
    if (f1 := utility.trials_of(planned.plan)) is None:
        return None
    return _map_of((utility.predictions, f1), (protocol, planned), pooling, resamples, utility.classifier)


def _map_of(
    tried: tuple[np.ndarray, np.ndarray | None], of: tuple[CrossValidation, TrialPlan],
    pooling: Pooling, resamples: int, classifier: str,
) -> UtilityMap:  # fmt: skip
    (predictions, trials_f1), (protocol, planned) = tried, of
    weights, clip = planned.weights, np.asarray(protocol.clip)[planned.used[planned.is_test]]
    truth = planned.labels[planned.is_test].astype(np.int16)
    n, seed = len(planned.activities), protocol.seed
    f1, boot = score_patches(truth, predictions, clip, n, resamples, LEVEL, seed, activity_weights=weights)
    trials_f1 = f1.T[None] if trials_f1 is None else trials_f1
    expected = expect(trials_f1, planned.plan, pooling, LEVEL, weights)
    return UtilityMap(
        f1=f1,
        **boot._asdict(),
        **vars(expected) | {"expected_low": np.minimum(expected.expected_low, most_shown(clip, LEVEL))},
        **{name: getattr(planned, name) for name in ("activities", "protocol", "left_out", "weights")},
        predictions=predictions,
        truth=truth,
        clip=clip.astype(np.str_),
        level=LEVEL,
        classifier=classifier,
        trial_f1=trials_f1 if planned.plan.pairs else None,
    )


def inputs_of(classifier: Any) -> str:
    """Inputs of a classifier, given as for `utility_map`: "features" or "windows"."""
    if isinstance(classifier, str) and classifier not in CLASSIFIERS:
        return "features"  # results by a classifier that is not here can be read all the same
    return _model(classifier).inputs


def unavailable(classifier: str) -> str:
    """Why a classifier cannot be used here, in a sentence; "" if it can."""
    if classifier not in CLASSIFIERS:
        return f"no classifier is called {classifier!r} here; there are {', '.join(CLASSIFIERS)}"
    return getattr(maker(classifier), "unavailable", str)()


def maker(name: str) -> Callable[..., Classifier]:
    """The class or function that makes the classifier of this name in CLASSIFIERS from a `seed`."""
    point = CLASSIFIERS[name]
    return Ridge if point is None else point.load()


def _model(classifier: Any, seed: int = 0, work: Path | None = None) -> Classifier:
    if not isinstance(classifier, str):
        return own(classifier)
    if classifier not in CLASSIFIERS:
        raise ValueError(unavailable(classifier))
    model: Any = maker(classifier)(seed=seed)
    resumes = work is not None and hasattr(model, "checkpoints")
    return replace(model, checkpoints=work / model.name) if resumes else model
