# SPDX-License-Identifier: GPL-3.0-or-later
"""The first look at a library's files, for the axis that is up in them."""

from collections import Counter
from collections.abc import Iterable
from contextlib import suppress
from functools import partial
from heapq import nsmallest
from operator import itemgetter
from pathlib import Path
from zlib import crc32

from ..keypoints.facts import PoseFacts
from ..keypoints.pose_files import NO_FACTS
from ..motion.sight import Kind, Sight
from ..motion.source import HIGHEST_RATE
from ..motion.up import Votes
from .formats import UP_SUFFIXES, read_motion
from .reader import Reader

SAMPLED = 64
"""Files of a library that are looked at for the axis that is up."""

MOST_SAMPLE_BYTES = 2**26


def look_up(reader: Reader, files: Iterable[tuple[str, Path]], pose: PoseFacts = NO_FACTS) -> Votes:
    """The votes of a library's files, each with its path inside, for the up axis, unless the format says it.

    A sample is read: some of each folder, the same ones whatever else the library holds. It ends early where
    files that kill or outlast their reader have taken as long as one clip may.
    """
    votes = Votes()
    if pose.up is not None:
        return votes
    asked = []
    for file, path in files:
        if file.lower().endswith(UP_SUFFIXES):
            asked.append((crc32(file.encode()), file, path))
        else:
            votes.others.append(file)
    before: Counter[str] = Counter()
    ranked = []
    for number, file, path in sorted(asked, key=itemgetter(0, 1)):
        folder = file.rpartition("/")[0]
        ranked.append((before[folder], number, file, path))
        before[folder] += 1
    known = pose.at(pose.rate or HIGHEST_RATE)  # any rate will do
    most_lost_s = reader.lost_s + reader.limit_s
    with reader.looking():
        for *_, path in nsmallest(SAMPLED, ranked):
            with suppress(Exception):  # whoever uses the file says what is wrong with it
                small = path.is_file() and path.stat().st_size <= MOST_SAMPLE_BYTES
                if small and reader.lost_s < most_lost_s:
                    votes.cast.extend(reader.read(path, partial(_sights, path, known)))
    return votes


def _sights(path: Path, pose: PoseFacts) -> list[tuple[Kind, Sight]]:
    """What a file shows of the axis that is up."""
    votes = Votes()
    with suppress(Exception):  # whoever uses the file says what is wrong with it
        read_motion(path, pose, votes)
    return votes.cast
