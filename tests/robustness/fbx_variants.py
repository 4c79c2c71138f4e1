# SPDX-License-Identifier: GPL-3.0-or-later
"""Variants of real FBX files with other tempo and amplitude, for large libraries and damaged files.

The animation curves inside the file are changed and the file written anew by Blender's own FBX parser and
writer, so that a variant has the bones, takes and mesh of its original and costs as much to import.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

Element = Any
"""A node of an FBX file as `io_scene_fbx.parse_fbx` gives it."""

LABELS = "labels.csv"
TEMPO = 0.15
AMPLITUDE = 0.15
"""Shares by which a variant is faster or slower, and its angles wider or narrower."""

ADDERS = {
    b"B": "add_bool", b"C": "add_char", b"Z": "add_int8", b"Y": "add_int16", b"I": "add_int32",
    b"L": "add_int64", b"F": "add_float32", b"D": "add_float64", b"R": "add_bytes", b"S": "add_string",
    b"i": "add_int32_array", b"l": "add_int64_array", b"f": "add_float32_array", b"d": "add_float64_array",
    b"b": "add_bool_array", b"c": "add_byte_array",
}  # fmt: skip


def write_library(folder: Path, data: Path, clips: int, seed: int = 0) -> int:
    """Write a library of so many clips: the real Mixamo files, then variants of them in turn.

    Parameters
    ----------
    folder : Path
        Made if missing. Files that are there already are kept.
    data : Path
        Folder with `motions.csv` and the files it lists.
    clips : int
    seed : int

    Returns
    -------
    int
        Clips written; fewer where none of the files can be varied.
    """
    with (data / "motions.csv").open(newline="", encoding="utf-8") as stream:
        listed = [row for row in csv.DictReader(stream) if row["format"] == "fbx" and row["activity"]]
    real = [row for row in listed if "_broken" not in row["file"] and int(row["frames"] or 0) >= 16]
    rows: list[tuple[str, str, str]] = []
    fixed: set[str] = set()
    copy = 0
    while len(rows) < clips and len(fixed) < len(real):
        for row in real:
            if len(rows) == clips or row["file"] in fixed:
                continue
            name = f"{row['activity']}/{Path(row['file']).stem} {row['sha256'][:6]}-{copy}.fbx"
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            if not target.exists():
                rng = np.random.default_rng([seed, copy, int(row["sha256"][:8], 16)])
                if copy == 0:
                    target.write_bytes((data / row["file"]).read_bytes())
                elif not write_variant(data / row["file"], target, rng):
                    fixed.add(row["file"])
                    continue
            rows.append((name, row["activity"], row["motion_key"]))
        copy += 1
    with (folder / LABELS).open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream).writerows([("file", "activity", "motion_key"), *rows])
    return len(rows)


def write_variant(source: Path, target: Path, rng: np.random.Generator) -> bool:
    """Write a variant of a binary FBX file; False where it is another kind of file."""
    tempo = (1 + TEMPO) ** rng.uniform(-1, 1)
    amplitude = 1 + AMPLITUDE * rng.uniform(-1, 1)
    return rewrite(source, target, lambda element: _varied(element, tempo, amplitude))


def rewrite(source: Path, target: Path, change: Callable[[Element], list]) -> bool:
    """Write a binary FBX file anew with the values of its elements changed.

    Parameters
    ----------
    source, target : Path
    change : callable
        Given each element (`id`, `props`, `props_type`, `elems`), gives its values.

    Returns
    -------
    bool
        False where `source` is another kind of file; nothing is written then.
    """
    encode_bin, parse_fbx = _fbx_modules()
    try:
        root, version = parse_fbx.parse(str(source))
    except (AssertionError, OSError):
        return False
    encoded = encode_bin.FBXElem(b"")
    encoded.elems.extend(_encoded(child, encode_bin, change) for child in root.elems if child is not None)
    encode_bin.write(str(target), encoded, version)
    return True


@cache
def _fbx_modules():
    """Blender's writer and parser of FBX files; they lie where Python finds them once their add-on is on."""
    import bpy

    bpy.ops.preferences.addon_enable(module="io_scene_fbx")
    from io_scene_fbx import encode_bin, parse_fbx

    return encode_bin, parse_fbx


def _varied(element: Element, tempo: float, amplitude: float) -> list:
    """An animation curve's values changed, and the takes' ends moved with it."""
    props = list(element.props)
    if element.id == b"KeyTime":
        props[0] = np.rint(np.asarray(props[0], dtype=np.float64) / tempo).astype(np.int64)
    elif element.id == b"KeyValueFloat":
        values = np.asarray(props[0], dtype=np.float64)
        props[0] = (values.mean() + amplitude * (values - values.mean())).astype(np.float32)
    elif element.id == b"P" and props and props[0] in (b"LocalStop", b"ReferenceStop"):
        props[-1] = round(props[-1] / tempo)
    return props


def _encoded(element: Element, encode_bin: Any, change: Callable[[Element], list]) -> Any:
    made = encode_bin.FBXElem(element.id)
    for kind, value in zip(element.props_type, change(element), strict=True):
        getattr(made, ADDERS[bytes([kind])])(value)
    made.elems.extend(_encoded(child, encode_bin, change) for child in element.elems if child is not None)
    return made
