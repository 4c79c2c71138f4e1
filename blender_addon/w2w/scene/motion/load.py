# SPDX-License-Identifier: GPL-3.0-or-later
"""Any motion file to a motion on the body, whatever wrote it."""

from collections import Counter
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from heapq import nsmallest
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32

from ...core.body.body import Body
from ...core.keypoints.facts import PoseFacts, up_beside
from ...core.keypoints.fit import UNSMOOTHED_HZ
from ...core.keypoints.likely_rest import ALONE, Rests, with_likely_rest
from ...core.keypoints.pose_files import NO_FACTS, JointPositions, read_joints
from ...core.library.library import UP_SUFFIXES, is_joint_file
from ...core.motion.axes import stood
from ...core.motion.believable import believed, unbroken
from ...core.motion.ground import on_the_ground
from ...core.motion.motion import SMPL_SUFFIXES, Motion, read_amass
from ...core.motion.sight import Kind, Sight
from ...core.motion.source import HIGHEST_RATE, SourceMotion, UnusableMotion
from ...core.motion.up import BY_ITSELF, Ups, Votes
from ...core.readers.asf_amc import AMC_SUFFIX, read_amc
from ...core.readers.bvh import BVH_SUFFIX, read_bvh
from ...core.readers.mvnx import MVNX_SUFFIX, read_mvnx
from ...core.readers.poselib import read_poselib
from ...core.reading.reader import Reader
from ...core.retargeting.bone_maps import BoneMap
from ...core.retargeting.retarget import retarget
from ..base.output import quiet_output


class RetargetedMotion(NamedTuple):
    """A motion without labels on the body, and where it came from.

    `take` is empty for SMPL files; `skeleton` says whose bone names matched, or the joint set; `scale` is
    body metres in one unit of the file; `cut` says which frames at the ends were left out, if any, and
    `up_guessed` which axis of the file is taken as up, if that is assumed, and `rest_guessed` where the
    rest pose comes from, if it is a guess.
    """

    motion: Motion
    take: str
    skeleton: str
    scale: float
    cut: str
    up_guessed: str = ""
    rest_guessed: str = ""

    def facts(self) -> dict[str, Any]:
        """What a clip's record says of it; what is guessed or cut only if they say something."""
        motion = self.motion
        about = {
            "take": self.take,
            "skeleton": self.skeleton,
            "frames": motion.n_frames,
            "frame_rate": motion.rate,
            "duration_s": round(motion.duration, 4),
            "scale": self.scale,
        }
        some = {"cut": self.cut, "up_guessed": self.up_guessed, "rest_guessed": self.rest_guessed}
        return about | {name: value for name, value in some.items() if value}


Source = SourceMotion | Motion | JointPositions
"""Contents of a motion file."""

SAMPLED = 64
"""Files of a library that are looked at for the axis that is up."""

MOST_SAMPLE_BYTES = 2**26


def read_motion(path: Path, pose: PoseFacts = NO_FACTS, ups: Ups = BY_ITSELF, animation: str = "") -> Source:
    """Read a motion file, or one animation in it: FBX, glTF and USD through Blender, all else directly.

    `pose` says what is known of joint positions, where the file holds those, and the frame rate and the axis
    that is up of any file, whatever it says itself; `ups` are its library's axes. Raises `UnusableMotion`
    if it cannot be used.
    """
    kind = path.suffix.lower()
    if kind == ".npy" and (skeleton := read_poselib(path, pose.rate)) is not None:
        return stood(skeleton, pose.up or "z", "z")
    if is_joint_file(path):
        return read_joints(path, pose, ups)
    if kind in (*SMPL_SUFFIXES, ".npy"):  # npy: Motion-X's
        up = pose.up or (up_beside(path) if kind in UP_SUFFIXES else None)
        return read_amass(path, pose.rate, up, ups, pose.person)
    if pose.person not in (None, 1):
        raise UnusableMotion("--person chooses among people in a result of video, which it is not")
    if kind == BVH_SUFFIX:
        return read_bvh(path, pose.rate, pose.up, ups)
    if kind == AMC_SUFFIX:
        return stood(read_amc(path, pose.rate), pose.up or "y", "y")
    if kind == MVNX_SUFFIX:
        return stood(read_mvnx(path, pose.rate), pose.up or "z", "z")
    from .takes import read_clip, written_up

    found = read_clip(path, pose.rate, animation)
    return found if pose.up is None else stood(found, pose.up, written_up(path))


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
                    votes.cast.extend(reader.read(_sights, path, known))
    return votes


def _sights(path: Path, pose: PoseFacts) -> list[tuple[Kind, Sight]]:
    """What a file shows of the axis that is up."""
    votes = Votes()
    with suppress(Exception):  # whoever uses the file says what is wrong with it
        read_motion(path, pose, votes)
    return votes.cast


def to_body(
    source: Source, body: Body, maps: Sequence[BoneMap] = (), rests: Rests = ALONE
) -> RetargetedMotion:
    """Retarget what a file holds to a body; the user's own bone maps are tried before the bundled ones.

    `rests` are the rest poses of its library's skeletons. Rest poses and damage at the ends are left out.
    Raises `UnusableMotion` if the skeleton cannot be matched, the joints make no body, or no body moves so.
    """
    if isinstance(source, JointPositions):
        part, cut = unbroken(body, source.fit(body, UNSMOOTHED_HZ).motion)
        fit = replace(source, positions=source.positions[part]).fit(body)
        kept = believed(body, fit.motion, None, part.start, cut, path_apart=False)
        name = source.joint_set.name
        return RetargetedMotion(kept.motion, "", name, fit.scale, kept.cut, source.up_guessed)
    if isinstance(source, Motion):
        kept = believed(body, on_the_ground(body, source))
        return RetargetedMotion(kept.motion, "", "SMPL", 1.0, kept.cut, source.up_guessed)
    rested, origin = with_likely_rest(source, body, maps, rests)
    found = retarget(rested, body, maps)
    kept = believed(body, found.motion, found.rest, source.first_frame, source.cut, found.path)
    about = (source.take, found.bone_map, found.scale, kept.cut, source.up_guessed, origin)
    return RetargetedMotion(kept.motion, *about)


def read_to_body(
    path: Path,
    body: Body,
    maps: Sequence[BoneMap],
    pose: PoseFacts,
    animation: str = "",
    ups: Ups = BY_ITSELF,
    rests: Rests = ALONE,
) -> RetargetedMotion:
    """The motion of a file, or of one animation in it, on the body; see `read_motion` and `to_body`."""
    with quiet_output():
        source = read_motion(path, pose, ups, animation)
    return to_body(source, body, maps, rests)
