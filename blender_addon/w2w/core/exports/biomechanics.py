# SPDX-License-Identifier: GPL-3.0-or-later
"""Files for OpenSim and Xsens's tools: orientations (.sto), joint centres (.trc), MT Manager's text."""

from pathlib import Path

import numpy as np

from ..body.body import JOINT_NAMES, Y_UP_TO_Z_UP
from ..files import write_text
from ..given import file_name
from ..imu.vendor_formats import write_orientation_sto, write_xsens_txt
from ..motion.skinning import joint_transforms
from ..rotations import continuous_quaternions
from .study_signals import WornClip, WornSignals


def write_opensim(folder: Path, signals: WornSignals) -> int:
    """Write ``CLIP.sto`` (orientations, z up) and ``CLIP.trc`` (joint centres, metres, y up) of each clip."""
    for clip in signals.clips():
        name = clip.recording.clip
        sites = tuple("_".join(site.split()) for site in signals.names)
        write_orientation_sto(folder / f"{name}.sto", _quaternions(clip), signals.rate, sites)
        positions = joint_transforms(signals.body, clip.motion)[1] @ Y_UP_TO_Z_UP
        write_trc(folder / f"{name}.trc", positions, signals.rate)
    return len(signals.study.clips)


def write_xsens(folder: Path, signals: WornSignals) -> int:
    """Write ``CLIP/SENSOR.txt`` as MT Manager exports it, orientation included."""
    for clip in signals.clips():
        place = folder / clip.recording.clip
        place.mkdir()
        quaternions = _quaternions(clip)
        for sensor, name in enumerate(map(file_name, signals.names)):
            write_xsens_txt(place / f"{name}.txt", clip.recording, sensor, quaternions[:, sensor])
    return len(signals.study.clips)


def write_trc(path: Path, positions: np.ndarray, rate: float) -> None:
    """Write the joints' centres (T, 24, 3) as OpenSim's track row column file, metres."""
    n_frames = len(positions)
    head = [
        f"PathFileType\t4\t(X/Y/Z)\t{path.name}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{rate:g}\t{rate:g}\t{n_frames}\t{len(JOINT_NAMES)}\tm\t{rate:g}\t1\t{n_frames}",
        "Frame#\tTime\t" + "\t\t\t".join(JOINT_NAMES) + "\t\t",
        "\t\t" + "\t".join(f"{axis}{k + 1}" for k in range(len(JOINT_NAMES)) for axis in "XYZ"),
        "",
    ]
    rows = (
        "\t".join([str(k + 1), repr(k / rate), *(f"{value:.6f}" for value in row)])
        for k, row in enumerate(positions.reshape(n_frames, -1).tolist())
    )
    write_text(path, "\n".join([*head, *rows]) + "\n")


def _quaternions(clip: WornClip) -> np.ndarray:
    """w, x, y, z, continuous in time, shape (T, N, 4)."""
    return np.moveaxis(continuous_quaternions(clip.orientations), 0, -1)
