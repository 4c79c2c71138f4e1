# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of worn sensors, of any data set or one's own, against the same sites of a simulated study."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from w2w.core.csv_tables import read_table
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.recordings import Recordings
from w2w.core.library.labels import same_label
from w2w.core.study.results import StudyResults

from ..validation.protocol import Analysis, Protocol
from ..validation.site_windows import site_windows
from .unpaired import Side, Simulated, patches_at_sites


@dataclass(frozen=True)
class Names:
    """Names of places and activities that the recordings and the study do not share."""

    sites: Mapping[str, str]  # place of the recordings -> W2W's name of it
    activities: Mapping[str, str]  # activity of the recordings -> that of the study

    @classmethod
    def read(cls, sites: Path | None, activities: Path | None) -> "Names":
        """Read a csv with columns place, site, and one with columns recorded, simulated; None for neither."""
        return cls(_pairs(sites, "place", "site"), _pairs(activities, "recorded", "simulated"))


def _pairs(path: Path | None, first: str, second: str) -> dict[str, str]:
    if path is None:
        return {}
    return {row[first]: row[second] for _, row in read_table(path, (first, second)).rows}


def own_protocol(recordings: Recordings, study: StudyResults, names: Names) -> Protocol:
    """What is compared: the places as sites, the activities of both, by the study's windows.

    Raises ValueError if a name of a place or an activity is neither's.
    """
    recorded = list(dict.fromkeys(one.activity for one in recordings))
    of_study = {same_label(clip.activity): clip.activity for clip in study.clips}
    told = [*map(same_label, names.activities.values())]
    for who, given, known in (
        ("recordings have", names.sites, recordings.places),
        ("recordings have", names.activities, recorded),
        ("study has", told, of_study),
    ):
        if strange := [name for name in given if name not in known]:
            raise ValueError(f"the {who} no {strange[0]!r}; there are {', '.join(known)}")
    real: dict[str, tuple[str, ...]] = {}
    for name in recorded:
        if shown := of_study.get(same_label(names.activities.get(name, name))):
            real[shown] = (*real.get(shown, ()), name)
    acc_only = not any(np.nan_to_num(one.gyr).any() for one in recordings)
    return Protocol(
        name="Your recordings",
        file_help="Folder of recordings.",
        read=lambda _: recordings,
        rate_hz=recordings.rate,
        sites={place: names.sites.get(place, place) for place in recordings.places},
        real=real,
        analyses=(),  # see `against_run`
        windows=study.config().windows,
        use="acc" if acc_only else "both",
    )


def against_run(
    protocol: Protocol, worn: Sequence[ImuRecording], study: StudyResults
) -> tuple[Protocol, Callable[[Analysis], Simulated]]:
    """The protocol for one analysis of all activities of a run, and what simulates it.

    People are left out where all are known, performers as the study left them out.

    Raises ValueError if fewer than two activities are on both sides.
    """
    shown = {same_label(clip.activity) for clip in study.clips}
    shared = tuple(name for name in protocol.real if same_label(name) in shown)
    if len(shared) < 2:
        there = ", ".join(sorted({clip.activity for clip in study.clips}))
        raise ValueError(f"fewer than two activities are recorded and simulated: the study has {there}")
    people = {one.subject for one in worn}
    by_subject = (len(people) > 1 and "" not in people, study.config().by_subject)
    analysis = Analysis("all activities", "Every activity that is recorded and simulated.", shared)

    def simulate(analysis: Analysis) -> Simulated:
        chosen, site_of, at = patches_at_sites(protocol.sites.values(), study.patches, study.body())
        names = {same_label(name): name for name in analysis.activities}
        made = [
            replace(
                study.recording(number, chosen), activity=name, subject=clip.subject, clip=clip.motion_key
            )
            for number, clip in enumerate(study.clips)
            if (name := names.get(same_label(clip.activity)))
        ]
        return Simulated(Side(made, site_windows(made, protocol.windows, protocol.use), {}), at, site_of, [])

    return replace(protocol, analyses=(analysis,), by_subject=by_subject), simulate
