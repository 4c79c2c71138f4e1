# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of motion files: their suffixes, who reads them, and what a reader must know of them.

Other packages add kinds by entry points of the group `w2w.readers`, each a `Format`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.metadata import EntryPoint, entry_points
from itertools import chain
from pathlib import Path

from ..keypoints.facts import PoseFacts, is_joint_file, may_hold_joints, side_car, up_beside
from ..keypoints.pose_files import NO_FACTS, JointPositions, read_joints
from ..motion.motion import Motion, read_amass
from ..motion.sight import Up, stood
from ..motion.smpl_layouts import RESULT_SUFFIXES
from ..motion.source import SourceMotion, UnusableMotion, reason_of
from ..motion.up import BY_ITSELF, Ups
from ..readers.asf_amc import AMC_SUFFIX, read_amc, skeleton_file
from ..readers.bvh import BVH_SUFFIX, read_bvh
from ..readers.import_checks import PLAIN_GLTF, USD_SUFFIXES, VRM_SUFFIXES
from ..readers.mvnx import MVNX_SUFFIX, read_mvnx
from ..readers.poselib import read_poselib
from ..wording import clean, join_words

GROUP = "w2w.readers"

Source = SourceMotion | Motion | JointPositions
"""Contents of a motion file."""

Read = Callable[[Path, PoseFacts, Ups, str], Source | None]
"""Reads a file, or one animation in it, by what is known of it and the axes of its library.

None if the file is of another kind with the same suffix. Raises `UnusableMotion`."""


@dataclass(frozen=True)
class Format:
    """A kind of motion files.

    `read` is None for those that Blender's importers read. `up` is the usual axis, None where the file says
    it; of a kind that `asks_up` a library may have to say it. `holds` tells by its content whether a file is
    of this kind, `beside` finds a second file that is read, and `people` says that there may be several in
    one. `taken_rate` is why a rate is taken where files name none. `is_risky` files are read in a worker
    only: a damaged one may crash or hang its reader, or unpack to anything. Another `version` has signals
    made anew.
    """

    name: str
    suffixes: tuple[str, ...]
    read: Read | None = None
    up: Up | None = None
    asks_up: bool = False
    holds: Callable[[Path], bool] | None = None
    beside: Callable[[Path], Path | None] | None = None
    people: bool = False
    taken_rate: str = ""
    is_risky: bool = False
    version: str = ""


GLTF_RATE = "glTF has times, no rate"
TABLES = (".csv", ".json")
"""Suffixes of files that may hold joints, or anything else."""

JOINTS = Format(
    "joints", (".npz", ".npy", ".trc", *TABLES), lambda path, pose, ups, _: read_joints(path, pose, ups),
    asks_up=True, holds=is_joint_file, beside=side_car, people=True,
)  # fmt: skip
POSES = replace(
    JOINTS, name="SMPL", suffixes=(".npz", ".npy", ".json"), holds=None,
    read=lambda path, pose, ups, _: read_amass(path, pose.rate, pose.up or up_beside(path), ups, pose.person),
)  # fmt: skip

OWN = (
    Format("FBX", (".fbx",), is_risky=True),
    Format(
        "BVH", (BVH_SUFFIX,), lambda path, pose, ups, _: read_bvh(path, pose.rate, pose.up, ups), up="y",
        asks_up=True,
    ),
    Format("glTF", PLAIN_GLTF, up="y", is_risky=True, taken_rate=GLTF_RATE),
    Format("VRM", VRM_SUFFIXES, up="y", is_risky=True, taken_rate=GLTF_RATE),
    Format("USD", USD_SUFFIXES, is_risky=True),
    # of one suffix the first is asked first
    Format("poselib", (".npy",), lambda path, pose, *_: read_poselib(path, pose.rate), up="z", people=True),
    JOINTS,
    POSES,
    replace(POSES, name="results of video", suffixes=RESULT_SUFFIXES, is_risky=True),
    replace(POSES, name="SMPL codec", suffixes=(".smpl",), up="y", asks_up=False),
    Format(
        "ASF/AMC", (AMC_SUFFIX,), lambda path, pose, *_: read_amc(path, pose.rate), up="y",
        beside=skeleton_file, taken_rate="AMC files name no rate, and CMU's and HDM05's have this one",
    ),
    Format("MVNX", (MVNX_SUFFIX,), lambda path, pose, *_: read_mvnx(path, pose.rate), up="z"),
    replace(JOINTS, name="C3D", suffixes=(".c3d",), is_risky=True),
)  # fmt: skip


def _of_other_packages() -> tuple[tuple[Format, ...], tuple[str, ...]]:
    """The kinds that other packages read, and a sentence on each that cannot be used."""
    found: list[Format] = []
    faults = []
    for point in sorted(entry_points(group=GROUP), key=lambda each: each.name):
        try:
            found.append(_checked(point, point.load(), [*OWN, *found]))
        except Exception as error:  # another's code
            faults.append(f"the reader '{clean(point.name)}' cannot be used: {reason_of(error)}")
    return tuple(found), tuple(faults)


def _checked(point: EntryPoint, made: object, known: list[Format]) -> Format:
    if not (isinstance(made, Format) and made.read and made.suffixes):
        raise ValueError(f"{point.value} is no Format with a reader and suffixes")
    if taken := {*made.suffixes} & {suffix for each in known for suffix in each.suffixes}:
        raise ValueError(f"{join_words(sorted(taken))} is read already")
    package = f"{point.dist.name} {point.dist.version}" if point.dist else point.value
    return replace(made, is_risky=True, version=" ".join(filter(None, (package, made.version))))


OTHERS, FAULTS = _of_other_packages()
FORMATS = (*OWN, *OTHERS)


def _suffixes(chosen: Callable[[Format], object]) -> tuple[str, ...]:
    """The suffixes of some formats, each once."""
    return tuple(dict.fromkeys(chain.from_iterable(each.suffixes for each in FORMATS if chosen(each))))


MOTION_SUFFIXES = tuple(suffix for suffix in _suffixes(lambda _: True) if suffix not in TABLES)
"""Suffixes of motion files, in lower case with the dot; tables may hold motion, too (`is_motion`)."""

UP_SUFFIXES = _suffixes(lambda each: each.asks_up)
"""Suffixes of files that may not say which axis is up."""

RISKY = _suffixes(lambda each: each.is_risky)
BLENDER_SUFFIXES = _suffixes(lambda each: each.read is None)
GLTF_SUFFIXES = (*PLAIN_GLTF, *VRM_SUFFIXES)

WAYS = {
    ".zip": "unpack zip",
    ".blend": "export the armature of a blend as FBX or BVH",
    **dict.fromkeys(
        (".mot", ".sto"),
        "mot and sto hold the angles of an OpenSim model: take the trc that they were made from, if it has "
        "joint centres (OpenCap, Pose2Sim)",
    ),
    **dict.fromkeys(
        (".mp4", ".mov", ".avi", ".webm"), "videos need a pose estimator, whose results are read"
    ),
}
"""How motions get out of files of kinds that are not read."""


def is_motion(path: Path) -> bool:
    """Whether a file is named as a motion, or is a table of joint positions."""
    suffix = path.suffix.lower()
    return suffix in MOTION_SUFFIXES or (suffix in TABLES and may_hold_joints(path))


def formats_of(path: Path) -> list[Format]:
    """The kinds that a file may be of by its suffix; the first that holds it is its own."""
    suffix = path.suffix.lower()
    return [each for each in FORMATS if suffix in each.suffixes]


def read_beside(path: Path) -> list[Path]:
    """Second files that are read: an AMC's skeleton, or the side-car with rate, up axis and joint set."""
    find = next((each.beside for each in formats_of(path) if each.beside), None)
    try:
        beside = find and find(path)
    except UnusableMotion:
        return []
    return [beside] if beside else []


def unknown(path: Path) -> UnusableMotion:
    """What is wrong with a file of a kind that is not read, and what to do."""
    kind = path.suffix.lower()
    way = [WAYS[kind]] if kind in WAYS else []
    what = f"'{kind}' is not a kind of motion file that can be read ({', '.join(MOTION_SUFFIXES)})"
    return UnusableMotion("; ".join([what, *way, *FAULTS]))


def read_motion(
    path: Path,
    pose: PoseFacts = NO_FACTS,
    ups: Ups = BY_ITSELF,
    animation: str = "",
    blender: Read | None = None,
) -> Source:
    """Read a motion file, or one animation in it, with `blender` for what its importers read.

    `pose` says what is known of joint positions, where the file holds those, and the frame rate and the axis
    that is up of any file, whatever it says itself; `ups` are its library's axes. Raises `UnusableMotion`
    if it cannot be used.
    """
    for kind in formats_of(path):
        if kind.holds and not kind.holds(path):
            continue
        if not kind.people and pose.person not in (None, 1):
            raise UnusableMotion("--person chooses among people in a result of video, which it is not")
        if (read := kind.read or blender) is None:
            raise UnusableMotion("Blender reads it, and was not asked")
        if (found := read(path, pose, ups, animation)) is None:
            continue
        if kind.read and kind.up and not kind.asks_up and isinstance(found, SourceMotion):
            return stood(found, pose.up or kind.up, kind.up)
        return found
    raise unknown(path)
