# SPDX-License-Identifier: GPL-3.0-or-later
"""PLY files with polygons of mixed sizes, text or binary (Turk 1994), which trimesh does not read."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

NUMBERS = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip

FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
FACE_LISTS = ("vertex_indices", "vertex_index")
LONGEST_HEADER = 65536


@dataclass
class _Element:
    """A kind of row: its properties as (name, type, type of the count that leads a list or "")."""

    name: str
    count: int
    properties: list[tuple[str, str, str]] = field(default_factory=list)


def read_ply(path: str | Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices and polygons of a PLY file.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    vertices : ndarray, shape (V, 3), float64
    corners : ndarray of int
        Vertex indices of all polygons, one behind the other.
    sizes : ndarray of int, shape (F,)
        Number of corners of each polygon.

    Raises
    ------
    ValueError
        If it is no PLY file, is damaged, or holds no vertices and faces.
    """
    content = Path(path).read_bytes()
    order, elements, body = _header(content)
    try:
        rows = _text_rows(elements, body) if order == "" else _binary_rows(elements, body, order)
        vertex, face = rows["vertex"], rows["face"]
        polygons = next(face[name] for name in FACE_LISTS if name in face)
        vertices = np.column_stack([np.asarray(vertex[axis], dtype=float) for axis in "xyz"])
    except (KeyError, StopIteration) as error:
        raise ValueError("it holds no vertices with x, y, z or no faces with vertex_indices") from error
    except (IndexError, ValueError) as error:
        raise ValueError(f"it is damaged or cut short: {error}") from error
    sizes = np.array([len(polygon) for polygon in polygons], dtype=int)
    return vertices, np.concatenate(polygons).astype(int) if len(polygons) else np.empty(0, int), sizes


def _header(content: bytes) -> tuple[str, list[_Element], bytes]:
    end = content.find(b"end_header", 0, LONGEST_HEADER)
    if not content.startswith(b"ply") or end < 0:
        raise ValueError("it is not a PLY file: it does not begin with 'ply' and a header")
    body = content[content.index(b"\n", end) + 1 :]
    order, elements = "", []
    try:
        for line in content[:end].decode("latin-1").splitlines():
            match line.split():
                case ["format", name, *_]:
                    order = FORMATS[name]
                case ["element", name, count]:
                    elements.append(_Element(name, int(count)))
                case ["property", "list", count, kind, name]:
                    elements[-1].properties.append((name, NUMBERS[kind], NUMBERS[count]))
                case ["property", kind, name]:
                    elements[-1].properties.append((name, NUMBERS[kind], ""))
    except (KeyError, ValueError, IndexError) as error:
        raise ValueError(f"its header cannot be understood: {error}") from error
    return order, elements, body


def _text_rows(elements: list[_Element], body: bytes) -> dict[str, dict[str, Any]]:
    lines = iter(body.decode("latin-1").splitlines())
    rows = {}
    for element in elements:
        columns: dict[str, list] = {name: [] for name, _, _ in element.properties}
        for _ in range(element.count):
            values = next(lines, "").split()
            at = 0
            for name, _, count in element.properties:
                if count:
                    size = int(values[at])
                    columns[name].append(np.array(values[at + 1 : at + 1 + size], dtype=float))
                    at += 1 + size
                else:
                    columns[name].append(float(values[at]))
                    at += 1
        rows[element.name] = columns
    return rows


def _binary_rows(elements: list[_Element], body: bytes, order: str) -> dict[str, dict[str, Any]]:
    stream = io.BytesIO(body)
    rows = {}
    for element in elements:
        if not any(count for _, _, count in element.properties):
            kind = np.dtype([(name, order + number) for name, number, _ in element.properties])
            table = np.frombuffer(stream.read(kind.itemsize * element.count), kind, element.count)
            rows[element.name] = {name: table[name] for name, _, _ in element.properties}
            continue
        columns: dict[str, list] = {name: [] for name, _, _ in element.properties}
        for _ in range(element.count):
            for name, number, count in element.properties:
                size = int(_take(stream, order + count, 1)[0]) if count else 1
                values = _take(stream, order + number, size)
                columns[name].append(values if count else values[0])
        rows[element.name] = columns
    return rows


def _take(stream: io.BytesIO, kind: str, count: int) -> np.ndarray:
    return np.frombuffer(stream.read(np.dtype(kind).itemsize * count), kind, count)


LARGEST = 4
"""Most corners of a polygon that a body's mesh has."""


def read_mesh(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Read a mesh without rig.

    Parameters
    ----------
    path : str or Path
        OBJ or PLY.

    Returns
    -------
    vertices : ndarray, shape (V, 3), float64
    polygons : ndarray, shape (F, 4), int64
        -1 in the last column of triangles.

    Raises
    ------
    ValueError
        If the file is damaged, holds no faces, or faces of more than four corners.
    """
    path = Path(path)
    reader = _read_obj if path.suffix.lower() == ".obj" else read_ply
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


def _read_obj(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The lines ``v`` and ``f`` of an OBJ; trimesh would cut its quads."""
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
