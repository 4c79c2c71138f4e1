# SPDX-License-Identifier: GPL-3.0-or-later
"""The first look at a library's files: the axis that is up in them, and rest poses where they have none."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from heapq import nsmallest
from operator import itemgetter
from pathlib import Path
from zlib import crc32

import numpy as np

from ..body.body import Body
from ..keypoints.facts import PoseFacts
from ..keypoints.likely_rest import likely_rest
from ..keypoints.pose_files import NO_FACTS
from ..motion.sight import Kind, Sight
from ..motion.source import HIGHEST_RATE, SourceMotion
from ..motion.up import BY_ITSELF, Ups, Votes
from ..readers.bvh import BVH_SUFFIX
from ..readers.bvh_text import BvhJoint, digest_of, read_skeleton
from ..retargeting.bone_maps import BoneMap
from ..retargeting.repair import are_rest_pose
from ..wording import count, name_bytes
from .clips import Rests
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


MOST_CLIPS, MOST_FRAMES, MOST_SKELETONS = 8, 250, 64
"""Clips of a skeleton that its rest pose is guessed from, frames of each, and skeletons of a library.

Clips of others are guessed one by one, as is one that has its skeleton for itself."""


def look_rests(
    reader: Reader,
    files: Iterable[tuple[str, Path]],
    body: Body,
    pose: PoseFacts = NO_FACTS,
    ups: Ups = BY_ITSELF,
    maps: Sequence[BoneMap] = (),
) -> Rests:
    """The rest poses of a library's skeletons, from its BVH files, each with its path inside the library.

    They are guessed from clips that follow from the files' names alone, for a body. A rest pose that leads
    one of them is taken as it is.
    """
    groups: dict[str, list[tuple[int, str, Path]]] = defaultdict(list)
    skeletons: dict[str, list[BvhJoint]] = {}
    for file, path in files:
        if path.suffix.lower() == BVH_SUFFIX:
            with suppress(Exception):  # whoever uses the file says what is wrong with it
                joints = read_skeleton(path)
                skeletons[skeleton := digest_of(joints)] = joints
                groups[skeleton].append((crc32(name_bytes(file)), file, path))
    lacking = [key for key, of in groups.items() if len(of) > 1 and not _rest(skeletons[key])]
    poses = []
    for skeleton in sorted(lacking, key=lambda key: (-len(groups[key]), key))[:MOST_SKELETONS]:
        clips = []
        for *_, path in nsmallest(MOST_CLIPS, groups[skeleton]):
            with suppress(Exception):
                if path.stat().st_size <= MOST_SAMPLE_BYTES:
                    with reader.looking():
                        clips.append(reader.read(path, partial(_part, path, pose, ups)))
        with suppress(Exception):
            known = [clip.rest for clip in clips if clip.rest_is_known]
            if (rest := known[0] if known else likely_rest(clips, body, maps)) is not None:
                said = "that leads one of its clips" if known else f"from {count('clip', len(clips))} of it"
                poses.append((skeleton, rest.tobytes(), said))
    kept = {skeleton for skeleton, *_ in poses}
    found = {file: skeleton for skeleton in sorted(kept) for _, file, _ in groups[skeleton]}
    return Rests(tuple(sorted(poses)), found)


def _rest(joints: Sequence[BvhJoint]) -> bool:
    """Whether a skeleton's offsets are a rest pose."""
    heads = np.zeros((len(joints), 3))
    for number, joint in enumerate(joints):
        heads[number] = (heads[joint.parent] if joint.parent >= 0 else 0) + np.array(joint.offset)
    return are_rest_pose([joint.name for joint in joints], heads)


def _part(path: Path, pose: PoseFacts, ups: Ups) -> SourceMotion:
    """A few seconds from the middle of a clip, at about 30 frames a second."""
    source = read_motion(path, pose, ups)
    assert isinstance(source, SourceMotion)
    step = max(1, round(source.rate / 30))
    start = max(0, source.n_frames - step * MOST_FRAMES) // 2
    return replace(source, matrices=source.matrices[start::step][:MOST_FRAMES], rate=source.rate / step)
