# SPDX-License-Identifier: GPL-3.0-or-later
"""The test on the MIG HAR dataset, whose garment the paper cites: fixed before anybody here had its data."""

from collections.abc import Callable
from pathlib import Path

from w2w.core.imu.presets import preset
from w2w.core.imu.recording import ImuRecording

from ..datasets.mighar import MIGHAR_RATE, WornAt, read_mighar
from .dsads import RULES as SPORTS
from .protocol import BY_POSTURE, MIXAMO, Protocol, Rule, usual_analyses

ACTIVITIES = ("walking", "running", "ascending stairs", "standing", "sitting", "typing", "eating")


def mighar(worn: WornAt, told: Callable[[str], None] = lambda _: None) -> Protocol:
    """The protocol for the sites at which a user placed the garment's sensors; `told` what cannot be read."""

    def read(path: Path) -> tuple[ImuRecording, ...]:
        recordings, left_out = read_mighar(path, worn.sensors)
        if left_out:
            told(f"Files that could not be used: {len(left_out)}; the first: {left_out[0]}.")
        return recordings

    return Protocol(
        name="MIG HAR",
        file_help="The data set's folder of subject1 to 12.",
        read=read,
        rate_hz=MIGHAR_RATE,
        sites=worn.sites,
        real={name: (name,) for name in ACTIVITIES}
        | {"running": ("jogging",), "ascending stairs": ("goingupstairs",)}
        | {"eating": ("eatingcookie", "eatingpasta")},
        rules=(  # no library shows writing, ironing, folding, brushing teeth, vacuuming or going down stairs
            Rule("typing", MIXAMO, r"(^|/)typing\.fbx$"),
            Rule("eating", MIXAMO, r"(^|/)eat(ing)?\.fbx$"),
            *(rule for rule in SPORTS if rule.activity in (*ACTIVITIES, BY_POSTURE)),
        ),
        analyses=usual_analyses(ACTIVITIES),
        sensor=preset("icm-20948"),
        worn_site_of=worn.site_of,
    )
