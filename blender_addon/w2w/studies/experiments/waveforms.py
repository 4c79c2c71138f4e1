# SPDX-License-Identifier: GPL-3.0-or-later
r"""Waveforms of worn sensors and of those that W2W makes of the same movement, on three trials.

    python -m w2w.studies.experiments.waveforms DATA

`DATA` holds imu/capsense (8 Xsens on a treadmill, kinematics from optical markers, OpenSim's virtual IMUs of
the same trial), imu/berkeley_mhad (acc.npz, and joints from markers in mocap) and mvnx (the sensors and the
segments of an MVN suit, its root below 3 Hz as docs/signals.md asks for). Ideal sensors but for MHAD's,
which read at most 2 g; both sides below 6 Hz. For each site: Pearson's r of the magnitudes at the best lag
within 0.1 s, and the ratio of their spreads, simulated over worn; with one constant rotation a sensor, fitted
on one half of the trial, r and root mean square error over the three axes on the other half.
"""

import argparse
import gzip
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import w2w
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w.core.keypoints.fit import fit_keypoints
from w2w.core.keypoints.joint_sets import JointSet
from w2w.core.motion.motion import smoothed_root
from w2w.core.motion.source import TO_Z_UP

from ..comparisons.site_simulator import SiteSimulator
from ..datasets.berkeley_mhad import read_berkeley_mhad
from ..datasets.opensim import frame_poses, read_table
from ..validation.correlation import magnitude_correlation
from ..validation.mhad import MHAD
from .gait import below, rms

LOWPASS_HZ, BAND_HZ, SUIT_ROOT_HZ, LONGEST_LAG_S = 6.0, 10.0, 3.0, 0.1
IDEAL = SensorModel()

CAPSENSE = ("toes_r", "toes_l", "tibia_r", "tibia_l", "femur_r", "femur_l", "pelvis")
"""Not the torso: the model's has no joint of its own."""

MVNX_SITES = {
    "Pelvis": "sacrum",
    "T8": "sternum",
    "Head": "back of head",
    **{
        f"{side}{segment}": f"{side.lower()} {place}"
        for side in ("Left", "Right")
        for segment, place in {
            "Shoulder": "posterior scapula", "UpperArm": "upper arm lateral", "ForeArm": "wrist dorsal",
            "Hand": "back of hand", "UpperLeg": "thigh lateral", "LowerLeg": "shin", "Foot": "instep",
        }.items()
    },
}  # fmt: skip
"""Where MVN's manual puts its sensors."""

MHAD_JOINTS = {
    "spine": ("spine2",), "neck": ("Neck",), "head": ("Head",),
    **{
        f"{side.lower()} {limb}": (f"{side}{joint}",)
        for side in ("Left", "Right")
        for limb, joint in {
            "hip": "UpLeg", "knee": "Leg", "ankle": "Foot", "toe": "ToeBase",
            "shoulder": "Arm", "elbow": "ForeArm", "wrist": "Hand",
        }.items()
    },
}  # fmt: skip
"""The body's landmarks among the joints of MHAD's skeleton."""


def main() -> None:
    """Print a table a trial."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("data", type=Path)
    data = parser.parse_args().data
    real, made, peer = capsense(data / "imu" / "capsense")
    print_table("Walking, W2W", [(real, made)])
    print_table("Walking, OpenSim", [(real, peer)])
    print_table("Jumping in place, mean of four trials", mhad(data / "imu" / "berkeley_mhad"))
    print_table("Kicking, MVN", [mvnx(data / "mvnx")])


def capsense(folder: Path) -> tuple[ImuRecording, ImuRecording, ImuRecording]:
    """Worn sensors, W2W's on the model's frames, and OpenSim's, from the markers' first frame on."""
    names, values = read_table(folder / "IKoutput_20to65secs.mot.gz")
    coordinates = dict(zip(names, values[..., 0].T, strict=True))
    model = folder / "OpenSimMOCOModelWithContactGeometry_placed.osim.gz"
    poses = frame_poses(model, coordinates)
    matrices = np.stack([TO_Z_UP @ poses[f"{site}_imu_offset"] for site in CAPSENSE], axis=1)
    made = synthesize(matrices, 100.0, Synthesis(rate_hz=100.0))
    times = coordinates["time"]
    worn = [_worn(folder / f"OpenSim_Sub02_CSBaseline_{kind}.trc.gz", times) for kind in ("Accel", "Gyro")]
    theirs = [
        _by_site(*read_table(folder / f"VirtualIMUProfiles_{kind}.sto.gz"))
        for kind in ("linear_accelerations", "angular_velocity")
    ]
    real, peer = (ImuRecording(*side, 100.0, CAPSENSE) for side in (worn, theirs))
    return real, made, peer


def _worn(path: Path, times: np.ndarray) -> np.ndarray:
    """Readings (T, N, 3) of a .trc at given times."""
    lines = gzip.decompress(path.read_bytes()).decode().splitlines()
    names = [name for name in lines[3].split("\t")[2:] if name.strip()]
    rows = np.array([line.split("\t")[1 : 2 + 3 * len(names)] for line in lines[5:] if line.strip()], float)
    first = int(np.argmin(abs(rows[:, 0] - times[0])))
    return _by_site(["time", *names], rows[first : first + len(times), 1:].reshape(len(times), -1, 3), 0)


def _by_site(names: list[str], values: np.ndarray, skipped: int = 1) -> np.ndarray:
    """The sites' columns in order; those before the sensors are skipped."""
    sites = [name.partition("_imu")[0] for name in names[1:]]
    return values[:, [sites.index(site) + skipped for site in CAPSENSE]]


def mhad(folder: Path) -> list[tuple[ImuRecording, ImuRecording]]:
    """Worn and simulated sensors of subject 1's jumps that have joints; both read at most 2 g."""
    worn = {one.clip: one for one in read_berkeley_mhad(folder / "acc.npz")}
    simulator = SiteSimulator(MHAD.sites, MHAD.rate_hz, MHAD.sensor)
    pairs = []
    with np.load(folder / "mocap" / "mhad_s01_a01.npz", allow_pickle=False) as joints:
        joint_set = JointSet("MHAD", tuple(joints["joint_names"].tolist()), MHAD_JOINTS)
        for trial in range(1, 5):
            path = joints[f"r{trial:02d}_pos"][::4]  # 480 Hz
            fit = fit_keypoints(path, 120.0, joint_set, simulator.body, "y", BAND_HZ)
            pairs.append((worn[f"s01_a01_r{trial:02d}"], simulator.record(fit.motion)))
    return pairs


def mvnx(folder: Path) -> tuple[ImuRecording, ImuRecording]:
    """The suit's own sensors, and W2W's on its segments."""
    with np.load(folder / "kicking-003.npz", allow_pickle=False) as suit:
        acc, gyr, sensors = (
            suit[name] for name in ("sensorAcceleration", "sensorAngularVelocity", "sensors")
        )
        rate = float(suit["rate_hz"])
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "kicking-003.mvnx"
        with gzip.open(folder / "kicking-003.mvnx.gz") as packed, path.open("wb") as file:
            shutil.copyfileobj(packed, file)
        motion = w2w.load(path)[0]
    simulator = SiteSimulator({site: MVNX_SITES[site] for site in sensors.tolist()}, rate, IDEAL)
    made = simulator.record(smoothed_root(motion, SUIT_ROOT_HZ))
    return ImuRecording(acc, gyr, rate, tuple(sensors.tolist())), made


def print_table(title: str, pairs: Sequence[tuple[ImuRecording, ImuRecording]]) -> None:
    """A row a site, the mean over trials, and the mean of the sites."""
    worn = pairs[0][0]
    kinds = [kind for kind in ("acc", "gyr") if getattr(worn, kind).any()]
    heads = [f"{kind} r, amplitude, r by axis, RMSE" for kind in kinds]
    print(f"\n{title}\n\n| site | {' | '.join(heads)} |\n|---|{'---|' * len(kinds)}")
    of_trials = [
        [compared(real.at([k]), made.at([k]), kinds) for k in range(worn.n_sensors)] for real, made in pairs
    ]
    found = np.mean(of_trials, axis=0)
    for site, row in zip((*worn.sites, "mean"), (*found, found.mean(axis=0)), strict=True):
        cells = [f"{r:.2f}, {ratio:.2f}, {axes:.2f}, {rmse:.2f}" for r, ratio, axes, rmse in row]
        print(f"| {site} | {' | '.join(cells)} |", flush=True)


def compared(real: ImuRecording, made: ImuRecording, kinds: list[str]) -> list[tuple[float, ...]]:
    """For one sensor and each kind: r of magnitudes, amplitude, and r and error by axis on the other half."""
    lag = 0.0
    found = []
    for kind in reversed(kinds):  # the gyroscope says best how late a sensor is
        pair = (getattr(side, kind)[:, 0] for side in (real, made))
        together = magnitude_correlation(*pair, real.rate, LOWPASS_HZ, LONGEST_LAG_S)
        lag = lag if found else together.lag_s
        found.append((together.best_lag, together.amplitude, *_by_axis(real, made, kind, lag)))
    return found[::-1]


def _by_axis(real: ImuRecording, made: ImuRecording, kind: str, lag_s: float) -> tuple[float, float]:
    """r and root mean square error over the axes, each half by the rotation that fits the other."""
    late = round(lag_s * real.rate)
    worn, ours = (getattr(below(side, LOWPASS_HZ), kind)[:, 0] for side in (real, made))
    n = min(len(worn) - max(late, 0), len(ours) - max(-late, 0))
    worn, ours = worn[max(late, 0) :][:n], ours[max(-late, 0) :][:n]
    halves = slice(0, n // 2), slice(n // 2, n)
    r, errors = [], []
    for half, other in (halves, halves[::-1]):
        turned = Rotation.align_vectors(worn[other], ours[other])[0].apply(ours[half])
        errors.append(turned - worn[half])
        a, b = (values - values.mean(axis=0) for values in (turned, worn[half]))
        r.append((a * b).sum() / np.sqrt((a * a).sum() * (b * b).sum()))
    return float(np.mean(r)), rms(np.concatenate(errors))


if __name__ == "__main__":
    main()
