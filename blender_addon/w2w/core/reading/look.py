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
from ..threads import Spread
from ..wording import count, name_bytes
from .clips import Rests
from .formats import UP_SUFFIXES, read_motion
from .reader import Reader, is_harmless

SAMPLED = 64
"""Files of a library that are looked at for the axis that is up."""

MOST_SAMPLE_BYTES = 2**26


def look_up(
    reader: Reader, files: Iterable[tuple[str, Path]], pose: PoseFacts = NO_FACTS, spread: Spread = map
) -> Votes:
    """The votes of a library's files, each with its path inside, for the up axis, unless the format says it.

    A sample is read: some of each folder, the same ones whatever else the library holds. `spread` looks at
    harmless files. It ends early where others kill or outlast their reader for as long as one clip may take.
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
    sights = partial(_sights, pose=known)
    chosen = [path for *_, path in nsmallest(SAMPLED, ranked) if _is_small(path)]
    harmless = [*filter(is_harmless, chosen)]
    seen = dict(zip(harmless, spread(sights, harmless), strict=True))
    with reader.looking():
        for path in chosen:
            if path not in seen and reader.lost_s < most_lost_s:
                with suppress(Exception):  # whoever uses the file says what is wrong with it
                    seen[path] = reader.call(path, partial(sights, path))
            votes.cast.extend(seen.get(path, ()))
    return votes


def _is_small(path: Path) -> bool:
    """Whether a file is there, and small enough for a first look."""
    with suppress(Exception):  # whoever uses the file says what is wrong with it
        return path.is_file() and path.stat().st_size <= MOST_SAMPLE_BYTES
    return False


def _sights(path: Path, pose: PoseFacts) -> list[tuple[Kind, Sight]]:
    """What a file shows of the axis that is up."""
    votes = Votes()
    with suppress(Exception):  # whoever uses the file says what is wrong with it
        read_motion(path, pose, votes)
    return votes.cast


MOST_CLIPS, MOST_FRAMES, MOST_SKELETONS = 8, 250, 64
"""Clips of a skeleton that its rest pose is guessed from, frames of each, and skeletons of a library.

Clips of others are guessed one by one, as is one that has its skeleton for itself."""


Lacking = dict[str, list[tuple[int, str, Path]]]
"""Files of each skeleton that needs a guess, largest first: a number to draw by, and paths in and of it."""


def lacking_rests(files: Iterable[tuple[str, Path]]) -> Lacking:
    """The skeletons without a rest pose among BVH files, each with its path inside their library."""
    groups: Lacking = defaultdict(list)
    skeletons: dict[str, list[BvhJoint]] = {}
    for file, path in files:
        if path.suffix.lower() == BVH_SUFFIX:
            with suppress(Exception):  # whoever uses the file says what is wrong with it
                joints = read_skeleton(path)
                skeletons[skeleton := digest_of(joints)] = joints
                groups[skeleton].append((crc32(name_bytes(file)), file, path))
    lacking = [key for key, of in groups.items() if len(of) > 1 and not _rest(skeletons[key])]
    largest = sorted(lacking, key=lambda key: (-len(groups[key]), key))[:MOST_SKELETONS]
    return {key: groups[key] for key in largest}


def look_rests(
    reader: Reader,
    lacking: Lacking,
    body: Body,
    pose: PoseFacts = NO_FACTS,
    ups: Ups = BY_ITSELF,
    maps: Sequence[BoneMap] = (),
    spread: Spread = map,
) -> Rests:
    """The rest poses of a library's skeletons that are `lacking_rests`.

    They are guessed from clips that follow from the files' names alone, for a body. A rest pose that leads
    one of them is taken as it is. `spread` guesses from harmless files.
    """
    parts: list[list[Path | SourceMotion]] = [[] for _ in lacking]
    with reader.looking():
        for files, some in zip(lacking.values(), parts, strict=True):
            for path in (path for *_, path in nsmallest(MOST_CLIPS, files) if _is_small(path)):
                with suppress(Exception):
                    harmless = is_harmless(path)
                    some.append(path if harmless else reader.call(path, partial(_part, path, pose, ups)))
    guesses = spread(partial(_guess, body=body, pose=pose, ups=ups, maps=maps), parts)
    poses = sorted((skeleton, *found) for skeleton, found in zip(lacking, guesses, strict=True) if found)
    return Rests(tuple(poses), {file: skeleton for skeleton, *_ in poses for _, file, _ in lacking[skeleton]})


def _guess(
    parts: Sequence[Path | SourceMotion], body: Body, pose: PoseFacts, ups: Ups, maps: Sequence[BoneMap]
) -> tuple[bytes, str] | None:
    """The rest matrices of a skeleton, by clips of it, and where they come from; None if they show none."""
    clips = []
    for part in parts:
        with suppress(Exception):
            clips.append(_part(part, pose, ups) if isinstance(part, Path) else part)
    with suppress(Exception):
        known = [clip.rest for clip in clips if clip.rest_is_known]
        if (rest := known[0] if known else likely_rest(clips, body, maps)) is not None:
            said = "that leads one of its clips" if known else f"from {count('clip', len(clips))} of it"
            return rest.tobytes(), said
    return None


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
