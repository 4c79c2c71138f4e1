# SPDX-License-Identifier: GPL-3.0-or-later
"""Data sets that have both video pose and worn sensors: the body follows the pose, clip by clip."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.core.keypoints.fit import fit_keypoints, seen_joints
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.motion.sight import UPS
from w2w.core.ranking.utility import inputs_of
from w2w.core.windows.windows import WindowSpec

from ..datasets.mmfit import CAMERA_RATE, DEVICES, NON_ACTIVITY, RATE_HZ, Exercise, read_mmfit
from ..datasets.vidimu import IMU_RATE, LOWER, SITES, UPPER, VIDEO_RATE, Trial, read_vidimu
from ..validation.protocol import Analysis, Protocol
from ..validation.site_windows import site_windows
from .by_protocol import Sides
from .site_simulator import SiteSimulator, error_sentence
from .unpaired import Side

NON_ACTIVITY_IS = ("activity", "background", "out")


def mmfit(non_activity: str = "activity") -> Protocol:
    """MM-Fit's protocol, with one of `NON_ACTIVITY_IS` for what is between its sets."""
    if non_activity not in NON_ACTIVITY_IS:
        raise ValueError(f"--non-activity must be {', '.join(NON_ACTIVITY_IS)}, not {non_activity}")
    background = non_activity == "background"

    def remarks(shown: Sequence[str]) -> list[str]:
        as_what = "background: trained against, compared with nothing" if background else "one of the classes"
        rests = (
            [f"What is done between the sets is {NON_ACTIVITY}, {as_what}."] if NON_ACTIVITY in shown else []
        )
        return [
            *rests,
            "Units of the real signals, the poses' upward axis and their sides were inferred from the files.",
        ]

    return Protocol(
        name="MM-Fit",
        title="MM-Fit: real and simulated devices",
        file_help="MM-Fit's folder of w00 to w20.",
        read=partial(read_mmfit, rests=non_activity != "out"),
        rate_hz=RATE_HZ,
        sites={site: site for site in DEVICES.values()},
        analyses=(Analysis("", "", sites=tuple(DEVICES.values())),),
        joints=JOINT_SETS["mm-fit-17"],
        by_subject=(False, False),
        pose_hz=CAMERA_RATE,
        windows=WindowSpec(length_s=5.0, stride_s=1.0),  # as long as the authors' own
        background=(NON_ACTIVITY,) if background else (),
        remarks=remarks,
    )


_RATES_ALONE = "Angular velocity only: the sensors' files hold no accelerations, on neither side used."

VIDIMU = Protocol(
    name="VIDIMU",
    title="VIDIMU: real and simulated sensors, angular velocity only",
    file_help="VIDIMU's folder dataset/videoandimus.",
    read=read_vidimu,
    rate_hz=IMU_RATE,
    sites=SITES,
    # the sensors sat on the legs for some activities, on the arms for the others
    analyses=(
        Analysis("lower body", _RATES_ALONE, sites=LOWER),
        Analysis("upper body", _RATES_ALONE, sites=UPPER),
    ),
    joints=JOINT_SETS["body-34"],
    by_subject=(False, False),
    pose_hz=VIDEO_RATE,
    windows=WindowSpec(length_s=2.0, stride_s=0.5),
    use="gyr",
)


def paired_sides(
    protocol: Protocol, trials: Sequence[Exercise | Trial], seed: int, analysis: Analysis
) -> Sides | None:
    """Both sides of the trials that wore an analysis's sensors; None if they show only one activity."""
    clips = [trial for trial in trials if set(trial.recording.sites) <= set(analysis.sites)]
    if len({trial.recording.activity for trial in clips}) < 2:
        return None
    worn = clips[0].recording.sites
    sites = {site: protocol.sites[site] for site in worn}
    simulator = SiteSimulator(sites, protocol.rate_hz, protocol.sensor, seed)
    pairs, notes = _pairs(simulator, clips, protocol)
    inputs, recordings = inputs_of(protocol.classifier), [list(side) for side in zip(*pairs, strict=True)]
    sides = [site_windows(side, protocol.windows, protocol.use, inputs) for side in recordings]
    shared = set(sides[0].clip.tolist()) & set(sides[1].clip.tolist())  # gaps may have cost a side a clip
    real, made = (side.some(np.isin(side.clip, list(shared))) for side in sides)
    notes = [*([analysis.why] if analysis.why else []), *notes, error_sentence(protocol.sensor)]
    notes += protocol.remarks([recording.activity for recording, _ in pairs])
    activities = tuple(sorted(set(real.activity.tolist())))
    found = (Side(*side, {}) for side in zip(recordings, (real, made), strict=True))
    return Sides(*found, worn, activities, notes, simulator.simulated_at)


def _pairs(
    simulator: SiteSimulator, clips: Sequence[Exercise | Trial], protocol: Protocol
) -> tuple[list[tuple[ImuRecording, ImuRecording]], list[str]]:
    """Real and simulated recordings of the same clips, cut to the same length."""
    seen = seen_joints(np.concatenate([clip.pose for clip in clips]), protocol.joints)
    up = UPS[int(seen.upright.argmax())]
    pairs, unusable, exchanged = [], [], 0
    for real, pose in clips:
        try:
            fit = fit_keypoints(
                pose, protocol.pose_hz, protocol.joints, simulator.body, up, protocol.kinect_hz
            )
            made = simulator.record(fit.motion.labelled(real.activity, real.subject, real.clip))
        except ValueError as error:
            unusable.append(f"{real.clip}: {error}")
            continue
        exchanged += fit.exchanged
        n = min(real.n_samples, made.n_samples)
        pairs.append(tuple(replace(side, acc=side.acc[:n], gyr=side.gyr[:n]) for side in (real, made)))
    if not pairs:
        raise ValueError(f"no clip's pose can be fitted: {unusable[0]}")
    notes = [
        f"Paired: {len(pairs)} clips seen and worn at once. Nothing is fitted between pose and sensors.",
        f"The poses' {up} axis was taken to point up; in {exchanged} clips left and right were exchanged.",
    ]
    if unusable:
        notes.append(f"{len(unusable)} clips could not be fitted, the first: {unusable[0]}.")
    return pairs, notes
