# SPDX-License-Identifier: GPL-3.0-or-later
"""Xsens MVN's open export, MVNX: segments' positions and orientations, read as a stream of XML."""

from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation

from ..motion.source import (
    MOST,
    NOT_FINITE,
    SourceMotion,
    UnusableMotion,
    reading,
    refuse_few_frames,
    refuse_too_long,
    size_and_head,
    usable_rate,
)
from ..wording import restated

MVNX_SUFFIX = ".mvnx"

REST_FRAMES = ("tpose", "identity", "npose")
"""Calibration poses, the best first: its own T-pose is nearest to W2W's."""

CHAINS = (
    ("Pelvis", "L5", "L3", "T12", "T8", "Neck", "Head"),
    *(("T8", f"{s}Shoulder", f"{s}UpperArm", f"{s}ForeArm", f"{s}Hand") for s in ("Left", "Right")),
    *(("Pelvis", f"{s}UpperLeg", f"{s}LowerLeg", f"{s}Foot", f"{s}Toe") for s in ("Left", "Right")),
)
"""Segments from the pelvis outwards (Xsens MVN User Manual, 23 segments)."""

PARENT = {child: parent for chain in CHAINS for parent, child in pairwise(chain)}

UNIT_LENGTH = 0.05
"""How far a quaternion's length may be from 1."""


class _Content(ElementTree.TreeBuilder):
    """The first person's frames; their elements are emptied as they end, so that long files fit in memory."""

    def __init__(self) -> None:
        super().__init__()
        self.segments: list[str] = []
        self.rate = 0.0
        self.poses: dict[str, dict[str, list[float]]] = {}
        self.frames: list[dict[str, list[float]]] = []
        self.subjects = 0

    def doctype(self, *_: str) -> None:
        """Refused: a file of MVN has none, and entities may grow without end."""
        raise UnusableMotion("it holds a document type, which no MVNX file has")

    def start(self, tag: str, attributes: dict[str, str]) -> ElementTree.Element:
        """Take up the rate and the names of segments."""
        if _plain(tag) == "subject":
            self.subjects += 1
            if self.subjects == 1:
                self.rate = _number(attributes.get("frameRate", "0"))
        elif _plain(tag) == "segment" and self.subjects == 1:
            self.segments.append(attributes.get("label", ""))
        return super().start(tag, attributes)

    def end(self, tag: str) -> ElementTree.Element:
        """Keep the numbers of a frame."""
        element = super().end(tag)
        if _plain(tag) == "frame":
            if self.subjects == 1:
                self._keep(element)
            element.clear()
        return element

    def _keep(self, element: ElementTree.Element) -> None:
        frame = {
            _plain(part.tag): [_number(word) for word in "".join(part.itertext()).split()]
            for part in element.iter()
            if _plain(part.tag) in ("orientation", "position")
        }
        kind = element.get("type", "normal")
        if kind == "normal":
            self.frames.append(frame)
            refuse_too_long(len(self.frames), max(1, len(self.segments)))
        else:
            self.poses.setdefault(kind, frame)


def read_mvnx(path: Path, rate: float | None = None) -> SourceMotion:
    """Read the first person's motion: metres, z up, at rest in MVN's T-pose.

    `rate` goes before the file's own frames per second. Raises UnusableMotion, with the reason, if the
    file cannot be used.
    """
    size_and_head(path)
    content = _Content()
    faults = ElementTree.ParseError, ValueError, LookupError
    with reading(), restated("it cannot be read as MVNX:", faults, UnusableMotion):
        ElementTree.parse(path, ElementTree.XMLParser(target=content))
    return _source(content, rate)


def _plain(tag: str) -> str:
    """A tag without its name space."""
    return tag.rpartition("}")[2]


def _number(word: str) -> float:
    try:  # called for each number of a file: a context would cost more than the reading
        return float(word)
    except ValueError:
        raise UnusableMotion(f"it holds '{word[:40]}' where a number should be") from None


def _source(content: _Content, rate: float | None) -> SourceMotion:
    names = tuple(content.segments)
    if "Pelvis" not in names or names[0] != "Pelvis":
        raise UnusableMotion("it names no segments of MVN's, the pelvis first: it is no MVNX file of a body")
    refuse_few_frames(len(content.frames))
    rate = usable_rate(content.rate, rate)
    rest = next((content.poses[name] for name in REST_FRAMES if name in content.poses), None)
    if rest is None:
        raise UnusableMotion("it holds no calibration pose (tpose, identity or npose) to start from")
    place = {name: number for number, name in enumerate(names)}
    parents = [place.get(PARENT.get(name, "Pelvis"), 0) if n else -1 for n, name in enumerate(names)]
    if any(parent >= number for number, parent in enumerate(parents)):
        raise UnusableMotion("its segments are not in MVN's order, from the pelvis outwards")
    stood, *matrices = (_matrices(frame, len(names)) for frame in (rest, *content.frames))
    moved, people = np.stack(matrices), max(1, content.subjects)
    return SourceMotion(names, np.array(parents), stood, moved, rate, people=people)


def _matrices(frame: dict[str, list[float]], n_segments: int) -> np.ndarray:
    """World matrix of each segment, shape (S, 4, 4)."""
    turns, places = (np.array(frame.get(name, ())) for name in ("orientation", "position"))
    if turns.shape != (4 * n_segments,) or places.shape != (3 * n_segments,):
        raise UnusableMotion(
            f"a frame holds {len(turns)} numbers of orientation and {len(places)} of position; its "
            f"{n_segments} segments need {4 * n_segments} and {3 * n_segments}: export it with both"
        )
    if not (np.abs(np.concatenate([turns, places])) < MOST).all():
        raise UnusableMotion(NOT_FINITE)
    turns = turns.reshape(-1, 4)
    if not (np.abs(np.linalg.norm(turns, axis=1) - 1) < UNIT_LENGTH).all():
        raise UnusableMotion("its orientations are no unit quaternions")
    matrices = np.tile(np.eye(4), (n_segments, 1, 1))
    matrices[:, :3, :3] = Rotation.from_quat(turns[:, [1, 2, 3, 0]]).as_matrix()
    matrices[:, :3, 3] = places.reshape(-1, 3)
    return matrices
