# SPDX-License-Identifier: GPL-3.0-or-later
"""Rankings that a new method should beat in the placement challenge, made from motion libraries."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from w2w.core.body.body import JOINT_INDEX, Body
from w2w.core.imu.presets import DEFAULT_SENSOR, PRESETS
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w.core.keypoints.fit import fit_keypoints
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w.core.patches.patches import sample_patches

from ..datasets.utd_mhad import UTD_IMU_RATE, read_utd_mhad
from ..validation.protocol import KINECT, Protocol
from ..validation.site_windows import SiteWindows, site_windows
from .challenge import SEED, WRIST
from .simple_rules import spread
from .site_simulator import SiteSimulator
from .unpaired import RegionSimulator, load_motions, scores_of
from .utd import KINECT_20, POSE_CUTOFF_HZ, SITES, WINDOW

ENERGY, PAPER, JOINTS, OURS = "signal energy", "the paper's protocol", "joints alone", "W2W"

Scores = dict[tuple[str, str], float]


def baselines(
    protocol: Protocol, libraries: Sequence[Path], told: Callable[[str], None] = lambda _: None
) -> dict[str, Scores]:
    """Scores of an unpaired data set's activities and sites by each baseline.

    Raises ValueError if no clip of the libraries takes part.
    """
    body, analysis = Body.bundled(), protocol.analyses[0]
    motions, _ = load_motions(protocol, libraries, body, told)
    simulator = RegionSimulator(body, protocol, SEED)
    made = simulator.side(motions, analysis).recordings
    touched = body.weights[sample_patches(body).triangles[simulator.patches]].sum(axis=1)  # (N, 24)
    joints = [
        int(touched[simulator.site_of == site].sum(axis=0).argmax()) for site in range(len(protocol.sites))
    ]
    taken, at_joints = {recording.clip for recording in made}, []
    for moving in motions:
        if moving.motion.clip in taken:
            settings = Synthesis(rate_hz=protocol.rate_hz)
            if moving.source != KINECT:
                settings = replace(settings, cutoff_hz=analysis.cutoff_hz)
            at_joints.append(_at_joints(body, moving.motion, joints, settings, protocol.sensor))
    windows = [site_windows(some, protocol.windows, protocol.use) for some in (made, at_joints)]
    return _scored(made, simulator.site_of, *windows, analysis.activities, tuple(protocol.sites))


def baselines_of_utd(path: Path) -> dict[str, Scores]:
    """Scores of UTD-MHAD's actions at the wrist, from the Kinect's skeletons of the same takes."""
    simulator = SiteSimulator({WRIST: SITES[WRIST]}, UTD_IMU_RATE, PRESETS[DEFAULT_SENSOR], SEED)
    joint = [JOINT_INDEX[WRIST.replace(" ", "_")]]
    made, at_joint = [], []
    for trial in read_utd_mhad(path):
        real = trial.recording
        if real.sites == (WRIST,):
            fit = fit_keypoints(
                trial.skeleton, trial.skeleton_rate, KINECT_20, simulator.body, "y", POSE_CUTOFF_HZ
            )
            motion = fit.motion.labelled(real.activity, real.subject, real.clip)
            made.append(simulator.record(motion))
            settings, sensor = Synthesis(rate_hz=UTD_IMU_RATE), PRESETS[DEFAULT_SENSOR]
            at_joint.append(_at_joints(simulator.body, motion, joint, settings, sensor))
    windows = [site_windows(some, WINDOW) for some in (made, at_joint)]
    activities = sorted({recording.activity for recording in made})
    return _scored(made, np.zeros(1, dtype=int), *windows, activities, (WRIST,))


def _at_joints(
    body: Body, motion: Motion, joints: Sequence[int], settings: Synthesis, sensor: SensorModel
) -> ImuRecording:
    """What sensors in the joints themselves would read, turned as the bones are."""
    rotations, positions = joint_transforms(body, motion)
    matrices = np.tile(np.eye(4), (motion.n_frames, len(joints), 1, 1))
    matrices[..., :3, :3], matrices[..., :3, 3] = rotations[:, joints], positions[:, joints]
    labelled = replace(synthesize(matrices, motion.rate, settings), clip=motion.clip)
    read = sensor.apply(labelled, SEED)
    return replace(read, activity=motion.activity, subject=motion.subject)


def _scored(
    made: Sequence[ImuRecording],
    site_of: np.ndarray,
    windows: SiteWindows,
    at_joints: SiteWindows,
    activities: Sequence[str],
    sites: Sequence[str],
) -> dict[str, Scores]:
    """The baselines' scores; of patches of one site the mean, but the best for the paper's."""
    belongs = site_of == np.arange(len(sites))[:, None]
    share = belongs / belongs.sum(axis=1, keepdims=True)
    ours = scores_of(windows, activities, site_of, SEED)
    joints = scores_of(at_joints, activities, None, SEED)
    every = windows._replace(clip=np.arange(len(windows.clip)).astype(str))  # windows of a clip on both sides
    paper = every.ranked(activities, by_subject=False, seed=SEED)
    best = np.stack([paper.f1[members].max(axis=0) for members in belongs])
    shown = sorted({recording.activity for recording in made})
    energy = [
        np.mean([spread(one) for one in made if one.activity == activity], axis=0) for activity in shown
    ]
    tables = {
        ENERGY: (shown, share @ np.array(energy).T),
        PAPER: (paper.activities, best),
        JOINTS: (joints.activities, joints.f1),
        OURS: (ours.activities, ours.f1),
    }
    return {
        name: {
            (activity, site): float(table[row, column])
            for row, site in enumerate(sites)
            for column, activity in enumerate(names)
        }
        for name, (names, table) in tables.items()
    }
