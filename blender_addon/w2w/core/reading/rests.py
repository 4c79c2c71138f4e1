# SPDX-License-Identifier: GPL-3.0-or-later
"""One guess of a rest pose for each skeleton of a library whose files have none."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from heapq import nsmallest
from pathlib import Path
from zlib import crc32

import numpy as np

from ..body.body import Body
from ..keypoints.facts import PoseFacts
from ..keypoints.likely_rest import Rests, likely_rest
from ..keypoints.pose_files import NO_FACTS
from ..motion.source import SourceMotion
from ..motion.up import BY_ITSELF, Ups
from ..readers.bvh import BVH_SUFFIX
from ..readers.bvh_text import BvhJoint, digest_of, read_skeleton
from ..retargeting.bone_maps import BoneMap
from ..retargeting.repair import are_rest_pose
from ..wording import count, name_bytes
from .formats import read_motion
from .look import MOST_SAMPLE_BYTES
from .reader import Reader

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
