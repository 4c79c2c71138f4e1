# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W from Python: motions become signals; a run's signals and ranking are read."""

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from numbers import Integral
from pathlib import Path
from typing import Any

from ..core.body.body import Body
from ..core.findings.cautions import full_scale_sentence
from ..core.given import Clips, given_path
from ..core.imu.presets import DEFAULT_SENSOR
from ..core.imu.recording import ImuRecording
from ..core.imu.sensor import SensorModel
from ..core.imu.synthesis import Synthesis
from ..core.motion.motion import Motion
from ..core.parameters import parameters_at, with_values
from ..core.patches.naming import resolve
from ..core.patches.patches import PatchSet
from ..core.study.choosing import stream_in
from ..core.study.clip_files import is_used
from ..core.study.config import StudyConfig
from ..core.study.results import StudyResults
from ..core.study.signals import simulate
from .loading import Motions
from .notebook import tracked
from .ranking import Ranking

ELSEWHERE = ("rate", "seed", "window", "garment", "recognise_by")
"""Parameters of signals that have an argument here or of `rank`, or that only a run knows how to follow."""

SETTABLE = {
    name: each for name, each in parameters_at("signals", StudyConfig).items() if name not in ELSEWHERE
}


@dataclass(frozen=True, eq=False)
class Signals(Clips[ImuRecording]):
    """Recordings of a sensor on every patch, one for each motion, with its labels."""

    recordings: tuple[ImuRecording, ...]
    patches: PatchSet
    motions: Motions
    config: StudyConfig
    of_clips = ("recordings", "motions")

    def __repr__(self) -> str:
        return f"<Signals: {len(self)} clips on {len(self.patches)} patches>"


def synthesize(
    motions: Motions | Sequence[Motion] | Motion,
    patches: PatchSet,
    sensor: str | SensorModel = DEFAULT_SENSOR,
    rate: float = 50.0,
    seed: int = 0,
    settings: Synthesis | None = None,
    body: Body | None = None,
    **parameters: Any,
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
    **parameters
        Others that signals depend on, by the names of `w2w run`'s options, such as ``root_band=3.0``.

    Returns
    -------
    Signals
        A sequence of `ImuRecording`: specific force, m/s2, and angular velocity, rad/s, sensor frame.

    Raises
    ------
    ValueError
        If the sensor or a parameter is unknown, the patches are of another body, or a motion is too short.

    Examples
    --------
    >>> patches = w2w.sample_patches(w2w.Body.bundled(), 24)
    >>> signals = w2w.synthesize(w2w.load("MY_CLIPS"), patches, sensor="bmi270")
    >>> signals[0].acc.shape
    (199, 24, 3)
    """
    if not isinstance(motions, Motions | Motion | Sequence):
        raise ValueError("motions come first, from load; then the patches, from sample_patches")
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
    if not isinstance(settings, Synthesis) or not isinstance(seed, Integral):
        raise ValueError(
            "settings is a Synthesis, such as Synthesis(cutoff_hz=20.0), and seed a whole number"
        )
    if settings.caution:
        warnings.warn(settings.caution, stacklevel=2)
    if unknown := parameters.keys() - SETTABLE.keys():
        raise ValueError(f"there is no parameter {min(unknown)!r}, but {', '.join(SETTABLE)}")
    config = StudyConfig(synthesis=settings, sensor=model.name, own_sensor=model, seed=int(seed))
    config = with_values(config, parameters)
    recordings = tuple(
        simulate(motions.body, patches, one, config) for one in tracked(motions, "Synthesizing signals")
    )
    about = [(one.clip or "a clip", model.full_scale_content(one)) for one in recordings]
    if caution := full_scale_sentence(about):
        warnings.warn(caution, stacklevel=2)
    return Signals(recordings, patches, motions, config)


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
    study = StudyResults.load(given_path(folder, "a results folder"))
    config = study.config()
    return Ranking(
        utility=study.utility, patches=study.patches, body=study.body(),
        inputs=study.inputs(config.classifier), labels=study.labels(), config=config,
        classifier=config.classifier, folder=study.out, clips=study.clips,
        details=[entry for entry in study.entries if is_used(entry)], stream=stream_in(study, config),
    )  # fmt: skip


def stream(
    folder: str | Path, placements: Sequence[str] | None = None, part: int = 0, parts: int = 1
) -> Iterator[ImuRecording]:
    """Read the signals of a run's clips, one after another, in memory for one.

    If `w2w run --no-signals` kept none, they are made again from the motions: the same to the last bit,
    or at `placements` but for single samples that are one step of the sensor off.

    Parameters
    ----------
    folder : str or Path
        What `w2w run` left.
    placements : sequence of str, optional
        Places by name, such as "left wrist", or patches; all patches by default.
    part, parts : int
        Which of how many equal parts of the clips; each worker of a data loader takes its own.

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
    study = StudyResults.load(given_path(folder, "a results folder"))
    chosen = None
    if not (isinstance(part, Integral) and isinstance(parts, Integral) and 0 <= part < parts):
        raise ValueError(f"part is a whole number from 0 to one below parts, not {part!r} of {parts!r}")
    if isinstance(placements, str) or not isinstance(placements, Sequence | None):
        raise ValueError(f"placements is a list of names, such as ['left wrist'], not {placements!r}")
    if placements is not None:
        chosen = [resolve(name, study.body(), study.patches) for name in placements]
    for clip in range(part, len(study.clips), parts):
        yield study.recording(clip, chosen)
