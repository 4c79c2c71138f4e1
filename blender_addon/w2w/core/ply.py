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
