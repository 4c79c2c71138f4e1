# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage whole files of every kind that W2W reads, and run each kind as a library.

    python -m tests.robustness.formats [--cases 200] [--seed 0] [--only .glb .c3d]

A library of a kind goes through `w2w run`, as a user's would, with limits of time and memory. Printed is by
kind how many files were read, refused with a sentence, or killed or outlasted the worker that read them. A
traceback, an end by a signal, a run that does not end, a file without a result or one for which W2W asks for
a report is a FAULT and the exit code 1.
"""

from __future__ import annotations

import argparse
import base64
import json
import pickle
import re
import struct
import subprocess
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from w2w.core.body.body import JOINT_NAMES, Body
from w2w.core.files import write_npz
from w2w.core.library.library import is_motion
from w2w.core.motion.examples import demo_motions
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w.core.reading.clips import to_body
from w2w.core.reading.formats import read_motion
from w2w.scene.motion.load import read_by_blender

from ..core.keypoints.test_pose_text import as_trc
from ..core.readers.test_asf_amc import write_acclaim
from ..core.readers.test_mvnx import write_mvnx
from ..made_glb import turns, write_glb
from .fuzz import DATA, PROMISED, TWO_BONES, _first_frames, mutated, mutated_npz

ROOT = Path(__file__).resolve().parents[2]

N_FRAMES = 90
LIMIT_S, MEMORY_GIB = 30, 2
RUN_S = 1800
"""Seconds that a library of a kind may take in all."""

KINDS = (
    ".bvh", ".fbx", ".glb", ".gltf", ".usda", ".usdc", ".npz", ".smpl", ".pkl", ".npy", ".csv", ".json",
    ".trc", ".c3d", ".amc", ".mvnx",
)  # fmt: skip

WORDS = (
    b"nan", b"inf", b"-inf", b"1e308", b"-1e308", b"1e-308", b"0", b"-1", b"4294967296",
    b"99999999999999999999", b"", b"\xff\xfe", b"x" * 200_000, b"9" * 5_000, b"\0", b"<", b"{", b"\"",
)  # fmt: skip
TOKEN = re.compile(rb"[^\s,;<>\"{}\[\]]+")


def whole_files(folder: Path, kinds: tuple[str, ...] = KINDS) -> dict[str, list[bytes]]:
    """Small files of a person in motion, by kind; of .amc with the skeleton before it."""
    body, motion = Body.bundled(), next(iter(demo_motions(1).values()))
    motion = Motion(motion.rotations[:N_FRAMES], motion.pelvis[:N_FRAMES], 30.0, "walk", "one", "whole")
    places = joint_transforms(body, motion)[1][..., [0, 2, 1]] * [1, 1, -1]
    times = np.arange(N_FRAMES) / 30
    path = write_glb(folder / "whole.glb", {"Wave": turns(times), "Hail": turns(times)}, times)
    found = {".bvh": _bvh(), ".glb": [path.read_bytes()], ".gltf": [_as_gltf(path.read_bytes())]}
    motion.save(folder / "whole.npz")
    with np.load(folder / "whole.npz") as stored:
        poses, trans = stored["poses"], stored["trans"]
    found[".npz"] = [(folder / "whole.npz").read_bytes()]
    write_npz(folder / "whole.npz", {"positions": places, "rate": np.array(30.0), "up": np.array("y")})
    found[".npz"].append((folder / "whole.npz").read_bytes())
    names = {
        "bodyPose": poses.reshape(N_FRAMES, 24, 3),
        "bodyTranslation": trans,
        "frameRate": np.float32(30),
    }
    write_npz(folder / "whole.smpl", names)
    found[".smpl"] = [(folder / "whole.smpl").read_bytes()]
    people = {"poses_60Hz": [poses, poses[:20]], "trans_60Hz": [trans, trans[:20]], "genders": ["m", "f"]}
    contents = ({"poses": poses, "trans": trans, "frame_rate": 30.0}, people)
    found[".pkl"] = [pickle.dumps(content, protocol) for content in contents for protocol in (0, 2, 4)]
    np.save(folder / "whole.npy", places)
    found[".npy"] = [(folder / "whole.npy").read_bytes()]
    columns = [f"{name}_{axis}" for name in JOINT_NAMES for axis in "xyz"]
    rows = [
        ",".join(map(repr, row)) for row in np.column_stack([times, places.reshape(N_FRAMES, -1)]).tolist()
    ]
    found[".csv"] = ["\n".join([",".join(["time", *columns]), *rows]).encode()]
    joints = {
        "rate": 30,
        "unit": "m",
        "up": "y",
        "joint_set": "smpl-24",
        "positions": places.round(4).tolist(),
    }
    smplx = {"transl": trans, "global_orient": poses[:, :3], "body_pose": poses[:, 3:66]}
    smplx = {name: array.round(4).tolist() for name, array in smplx.items()} | {"fps": 30}
    found[".json"] = [json.dumps(joints).encode(), json.dumps(smplx).encode()]
    found[".trc"] = [as_trc(JOINT_NAMES, places, "m").encode()]
    found[".mvnx"] = [write_mvnx(folder / "whole.mvnx", body, motion).read_bytes()]
    path = write_acclaim(folder, body, motion)
    found[".amc"] = [(folder / "07.asf").read_bytes() + b"SPLIT" + path.read_bytes()]
    if ".c3d" in kinds:
        found[".c3d"] = [_c3d(folder / "whole.c3d", places)]
    if {".fbx", ".usda", ".usdc"} & set(kinds):
        found |= _by_blender(folder)
    return {kind: found[kind] for kind in kinds}


def _bvh() -> list[bytes]:
    files = [next(iter(sorted(path.glob("*.bvh"))), None) for path in sorted((DATA / "bvh").glob("*"))]
    return [_first_frames(path.read_bytes(), N_FRAMES) for path in files if path] or [TWO_BONES]


def _as_gltf(data: bytes) -> bytes:
    content, rest = _parts_of_glb(data)
    content["buffers"][0]["uri"] = (
        "data:application/octet-stream;base64," + base64.b64encode(rest[8:]).decode()
    )
    return json.dumps(content).encode()


def _parts_of_glb(data: bytes) -> tuple[dict, bytes]:
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[20 + length :]


def _c3d(path: Path, places: np.ndarray) -> bytes:
    """Joint centres, and segments."""
    import ezc3d

    made = ezc3d.c3d()
    point = made["parameters"]["POINT"]
    point["RATE"]["value"], point["UNITS"]["value"] = [30.0], ["m"]
    point["LABELS"]["value"] = tuple(name.title().replace("_", "") for name in JOINT_NAMES)
    made["data"]["points"] = np.concatenate([places.transpose(2, 1, 0), np.ones((1, *places.shape[1::-1]))])
    made["data"]["rotations"] = np.tile(np.eye(4)[:, :, None, None], (1, 1, 2, len(places)))
    made.add_parameter("ROTATION", "LABELS", ["pelvis_4X4", "l_thigh_4X4"])
    made.write(str(path))
    return path.read_bytes()


def _by_blender(folder: Path) -> dict[str, list[bytes]]:
    """The glTF file as Blender writes it as FBX and USD, and a real FBX where there is one."""
    import bpy

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(folder / "whole.glb"))
    bpy.context.scene.frame_end = N_FRAMES
    bpy.ops.export_scene.fbx(filepath=str(folder / "whole.fbx"))
    found = {".fbx": [(folder / "whole.fbx").read_bytes()]}
    real = [path for path in sorted(DATA.glob("mixamo/**/*.fbx")) if 0 < path.stat().st_size < 2**19]
    found[".fbx"] += [path.read_bytes() for path in real[:60:12]]
    for kind in (".usda", ".usdc"):
        path = folder / f"whole{kind}"
        bpy.ops.wm.usd_export(filepath=str(path), export_animation=True, export_armatures=True)
        found[kind] = [path.read_bytes()]
    return found


def mutated_text(data: bytes, rng: np.random.Generator) -> bytes:
    """A text whose words are replaced by impossible ones and whose lines are lost, doubled and swapped."""
    for _ in range(rng.integers(1, 5)):
        if rng.random() < 0.3:
            lines = data.split(b"\n")
            one, other = rng.integers(0, len(lines), 2)
            lines[one : one + 1] = [[lines[other]], [], [lines[other], lines[one]]][rng.integers(0, 3)]
            data = b"\n".join(lines)
        elif found := list(TOKEN.finditer(data[:20_000] if rng.random() < 0.5 else data)):
            word = found[rng.integers(0, len(found))]
            data = data[: word.start()] + WORDS[rng.integers(0, len(WORDS))] + data[word.end() :]
    return data


def mutated_json(content: object, rng: np.random.Generator) -> object:
    """Nested lists and dicts with some parts lost, doubled or replaced by what does not belong there."""
    content = json.loads(json.dumps(content))
    deep: list[object] = []
    for _ in range(900):
        deep = [deep]
    odd = [
        None, True, -1, 0, 10**18, 1e308, float("nan"), float("inf"), "", "x" * 100_000, [], {}, [[]], deep,
        [0] * 10_000, {"a": {}}, "data:,", 1.5, "../x",
    ]  # fmt: skip
    for _ in range(rng.integers(1, 4)):
        part, key = content, None
        while isinstance(part, (dict, list)) and part and (key is None or rng.random() < 0.8):
            holder, keys = part, list(part) if isinstance(part, dict) else range(len(part))
            key = keys[int(rng.integers(0, len(keys)))]
            part = holder[key]
        if key is None:
            continue
        if rng.random() < 0.2:
            del holder[key]
        elif rng.random() < 0.2 and isinstance(holder, list):
            holder.append(json.loads(json.dumps(part)))
        else:
            holder[key] = json.loads(json.dumps(odd[rng.integers(0, len(odd))]))
    return content


def damaged(kind: str, data: bytes, other: bytes, rng: np.random.Generator) -> bytes:
    """A damaged copy of a file of a kind, in a way that suits it or by its bytes."""
    if rng.random() < 0.4:
        return mutated(data, rng, other)
    if kind in (".npz", ".smpl"):
        return mutated_npz(data, rng)
    if kind in (".json", ".gltf"):
        return json.dumps(mutated_json(json.loads(data), rng)).encode()
    if kind == ".glb":
        content, rest = _parts_of_glb(data)
        text = json.dumps(mutated_json(content, rng)).encode()
        text += b" " * (-len(text) % 4)
        rest = mutated(rest, rng) if rng.random() < 0.3 else rest
        return (
            b"glTF" + struct.pack("<IIII", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest
        )
    if kind in (".fbx", ".c3d", ".npy", ".pkl", ".usdc"):
        return mutated(data, rng, other)
    return mutated_text(data, rng)


def write_library(folder: Path, kind: str, files: list[bytes], cases: int, seed: int) -> None:
    """Damaged files as a library of two activities, the first of each whole; some files beside are hurt."""
    rng = np.random.default_rng(seed)
    for number in range(cases):
        place = folder / ("walk", "run")[number % 2]
        place.mkdir(parents=True, exist_ok=True)
        path = place / f"{number}{kind}"
        data, other = (files[rng.integers(0, len(files))] for _ in range(2))
        hurt = partial(damaged, kind, other=other, rng=rng) if number > 1 else bytes
        if kind == ".amc":
            parts, which = data.split(b"SPLIT"), int(rng.integers(0, 2))
            parts[which] = hurt(parts[which])
            path.with_suffix(".asf").write_bytes(parts[0])
            path.write_bytes(parts[1])
            continue
        path.write_bytes(hurt(data))
        if kind in (".npy", ".csv"):
            beside = b'{"rate": 30, "up": "y"}'
            path.with_suffix(".json").write_bytes(mutated_text(beside, rng) if rng.random() < 0.2 else beside)


def fuzz_here(folder: Path, kinds: Sequence[str], cases: int, seed: int) -> Counter[str]:
    """What became of so many damaged files of each kind, read and put on the body in this process."""
    found: Counter[str] = Counter()
    for kind, files in whole_files(folder, tuple(kinds)).items():
        write_library(folder / kind[1:], kind, files, cases, seed)
        for path in sorted((folder / kind[1:]).rglob(f"*{kind}")):
            try:
                with warnings.catch_warnings(action="error", category=RuntimeWarning):
                    to_body(read_motion(path, blender=read_by_blender), Body.bundled())
                found[f"{kind}: read"] += 1
            except PROMISED:
                found[f"{kind}: refused"] += 1
            except Exception as error:
                found[f"FAULT {path.name}: {type(error).__name__}: {error}"] += 1
    return found


def fuzz_kind(folder: Path, kind: str, files: list[bytes], cases: int, seed: int) -> Counter[str]:
    """What became of damaged files of a kind in a run."""
    library, out = folder / "library", folder / "out"
    write_library(library, kind, files, cases, seed)
    words = ["run", library, "--out", out, "--patches", 8, "--workers", 2, "--no-pictures", "--no-report"]
    words += ["--no-signals", "--clip-limit", LIMIT_S, "--clip-memory", MEMORY_GIB, "--log-json"]
    found: Counter[str] = Counter()
    command = [sys.executable, str(ROOT / "headless/w2w.py"), *map(str, words)]
    run = partial(subprocess.run, capture_output=True, text=True, timeout=RUN_S, check=False)
    try:
        if "give --pose-up" in (done := run(command)).stdout + done.stderr:  # what would say it is damaged
            done = run([*command, "--pose-up", "y"])
    except subprocess.TimeoutExpired:
        found["FAULT: the run does not end"] += 1
        return found
    said, listed = done.stdout + done.stderr, out / "clips.jsonl"
    if "Traceback" in said or done.returncode not in (0, 1):
        found[f"FAULT: exit code {done.returncode}: {said[-2000:]}"] += 1
    rows = [json.loads(line) for line in listed.read_text().splitlines()] if listed.exists() else []
    for row in rows:
        found[_became(str(row.get("skipped", "")))] += 1
    told = {row["file"].partition(kind)[0] for row in rows}
    motions = [path for path in library.rglob(f"*{kind}") if is_motion(path)]
    if lost := [path for path in motions if f"{path.parent.name}/{path.stem}" not in told]:
        found["FAULT: files without a result"] += len(lost)
    if not found["read"]:
        found["FAULT: whole files are not read"] += 1
    return found


def _became(reason: str) -> str:
    if "please report" in reason:
        return f"FAULT: {reason}"
    ends = {"reads it crashed, or took longer": "killed or outlasted its worker"}
    ends |= {"reads it crashed": "killed its worker", "longer than the limit": "outlasted its worker"}
    ends |= {"of memory": "took too much memory"}
    return next((end for words, end in ends.items() if words in reason), "refused" if reason else "read")


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", default=KINDS, choices=KINDS, metavar="KIND")
    choice = parser.parse_args()
    faults = False
    with tempfile.TemporaryDirectory() as place:
        files = whole_files(Path(place), tuple(choice.only))
        for kind in choice.only:
            folder = Path(place) / kind[1:]
            folder.mkdir()
            found = fuzz_kind(folder, kind, files[kind], choice.cases, choice.seed)
            faults |= any(name.startswith("FAULT") for name in found)
            became = ", ".join(f"{count} {name}" for name, count in sorted(found.items()))
            print(f"{kind}: {became}", flush=True)
    if faults:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
