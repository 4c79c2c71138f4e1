# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices and polygons of OBJ and PLY files; trimesh would cut the quads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from plyfile import PlyData, PlyParseError

FACE_LISTS = ("vertex_indices", "vertex_index")

LARGEST = 4
"""Most corners of a polygon that a body's mesh has."""


def read_mesh(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) and polygons (F, 4) of an OBJ or PLY; -1 in the last column of triangles.

    Raises ValueError if the file is damaged, holds no faces, or faces of more than four corners.
    """
    path = Path(path)
    reader = _read_obj if path.suffix.lower() == ".obj" else _read_ply
    vertices, corners, sizes = reader(path)
    if len(vertices) == 0 or len(sizes) == 0:
        raise ValueError("it holds no mesh: no vertices or no faces")
    if sizes.min() < 3 or sizes.max() > LARGEST:
        raise ValueError(f"it holds faces of {sizes.min()} to {sizes.max()} corners, expected 3 or 4")
    if corners.min() < 0 or corners.max() >= len(vertices):
        raise ValueError(f"its faces name vertices that it does not hold ({len(vertices)} vertices)")
    polygons = np.full((len(sizes), LARGEST), -1, dtype=np.int64)
    polygons[np.arange(LARGEST) < sizes[:, None]] = corners
    return vertices, polygons


def _read_ply(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices, the corners of all polygons one behind the other, and how many each polygon has."""
    try:
        content = PlyData.read(str(path))
    except (PlyParseError, ValueError, MemoryError) as error:
        raise ValueError(f"it is not a PLY file, damaged or cut short: {error}") from error
    try:
        vertex, face = content["vertex"].data, content["face"].data
        vertices = np.column_stack([vertex[axis].astype(float) for axis in "xyz"])
        polygons = next(face[name] for name in FACE_LISTS if name in face.dtype.names)
        sizes = np.array([len(polygon) for polygon in polygons], dtype=int)
    except (KeyError, StopIteration, TypeError, ValueError) as error:
        raise ValueError("it holds no vertices with x, y, z or no faces with vertex_indices") from error
    return vertices, np.concatenate(polygons).astype(int) if len(polygons) else np.empty(0, int), sizes


def _read_obj(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lines ``v`` and ``f`` of an OBJ."""
    positions, corners, sizes = [], [], []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        kind, *fields = line.split("#", 1)[0].split() or [""]
        try:
            if kind == "v":
                positions.append([float(field) for field in fields[:3]])
            elif kind == "f":
                named = [int(field.partition("/")[0]) for field in fields]
                corners += [name - 1 if name > 0 else len(positions) + name for name in named]
                sizes.append(len(named))
        except ValueError as error:
            raise ValueError(f"line {number} cannot be read as OBJ: {line.strip()[:60]!r}") from error
    if any(len(position) != 3 for position in positions):
        raise ValueError("a vertex has fewer than three coordinates")
    return np.array(positions, dtype=float).reshape(-1, 3), np.array(corners, int), np.array(sizes, int)
