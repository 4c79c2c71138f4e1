# SPDX-License-Identifier: GPL-3.0-or-later
"""Feed damaged files to every reader: a sentence or a result, never another error, a crash or a hang.

    python -m tests.robustness.fuzz [--cases 10000] [--seed 0]    # W2W's own readers, in this process

Files are real ones (and small ones made here) with bytes flipped, cut, doubled, spliced and set to extremes;
npz files also with whole arrays changed inside, where a checksum would catch single bytes, BVH files also
with lines and words moved, lost and replaced. Printed are the cases by reader and how each ended; an error
that a reader does not promise is a FAULT and the exit code 1.
"""

from __future__ import annotations

import argparse
import io
import pickle
import pickletools
import tempfile
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from w2w.core.files import write_npz
from w2w.core.imu.recording import ImuRecording
from w2w.core.library.library import read_library
from w2w.core.motion.motion import read_amass
from w2w.core.motion.source import UnusableMotion
from w2w.core.pickles import read_npy_object, read_result
from w2w.core.readers.bvh import read_bvh
from w2w.core.retargeting.bone_maps import BONE_MAPS, BoneMap
from w2w.core.windows.inputs import StoredArray

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
PROMISED = (UnusableMotion, ValueError, OSError)
"""What a reader may raise; LibraryError is a ValueError."""

EXTREMES = (b"\0" * 4, b"\xff" * 4, b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0\0\xc0\x7f", b"\0\0\x80\x7f")


CODES = [operation.code for operation in pickletools.opcodes]

WORDS = (
    b"nan", b"1e9", b"-1e9", b"1e308", b"0", b"1e-300", b"{", b"}", b"ROOT x", b"JOINT y", b"End Site",
    b"MOTION", b"CHANNELS 0", b"OFFSET 0 0 0", b"Xscale", b"1_0", b"0x1p3", b"infinity",
)  # fmt: skip

TWO_BONES = b"""HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Chest
  {
    OFFSET 0 10 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 10 0
    }
  }
}
MOTION
Frames: 5
Frame Time: 0.0333
""" + b"".join(b"0 90 %d 1 2 %d 3 4 5\n" % (row, row) for row in range(5))


def mutated(data: bytes, rng: np.random.Generator, other: bytes = b"") -> bytes:
    """A damaged copy of a file's bytes."""
    damaged = bytearray(data)
    for _ in range(rng.integers(1, 6)):
        size = len(damaged)
        if size < 8:
            damaged += rng.bytes(8)
            continue
        place, length = int(rng.integers(0, size - 4)), int(2 ** rng.uniform(0, 10))
        kind = rng.integers(0, 7)
        if kind == 0:
            damaged[place] ^= 1 << int(rng.integers(0, 8))
        elif kind == 1:
            damaged[place : place + 4] = EXTREMES[rng.integers(0, len(EXTREMES))]
        elif kind == 2:
            del damaged[place : size if rng.random() < 0.3 else place + length]
        elif kind == 3:
            damaged[place:place] = damaged[place : place + length]
        elif kind == 4:
            damaged[place : place + length] = rng.bytes(length)
        elif kind == 5 and other:
            start = int(rng.integers(0, len(other)))
            damaged[place : place + length] = other[start : start + length]
        else:
            damaged[place : place + 1] = str(int(rng.integers(-(10**9), 10**9))).encode()
    return bytes(damaged)


def mutated_words(data: bytes, rng: np.random.Generator) -> bytes:
    """A text whose lines and words are moved, doubled, lost and replaced."""
    lines = data.split(b"\n")
    for _ in range(rng.integers(1, 4)):
        one, other = rng.integers(0, len(lines), 2)
        kind = rng.integers(0, 6)
        if kind == 0:
            lines[one], lines[other] = lines[other], lines[one]
        elif kind == 1:
            lines.insert(one, lines[other])
        elif kind == 2 and len(lines) > 1:
            del lines[one]
        else:
            words = lines[one].split(b" ")
            place = int(rng.integers(0, len(words)))
            words[place : place + int(kind != 3)] = [WORDS[rng.integers(0, len(WORDS))]] * int(kind != 4)
            lines[one] = b" ".join(words)
    return b"\n".join(lines)


def mutated_steps(data: bytes, rng: np.random.Generator) -> bytes:
    """A pickle, alone or behind an npy's header, whose operations are moved, doubled, lost and made up."""
    start = data.index(b"\n") + 1 if data.startswith(b"\x93NUMPY") else 0
    places = [place for _, _, place in pickletools.genops(data[start:])] + [len(data) - start]
    steps = [data[start + a : start + b] for a, b in pairwise(places)]
    for _ in range(rng.integers(1, 5)):
        one, other = rng.integers(0, len(steps), 2)
        kind = rng.integers(0, 5)
        if kind == 0:
            steps[one], steps[other] = steps[other], steps[one]
        elif kind == 1:
            steps[one:one] = [steps[other]] * int(2 ** rng.uniform(0, 12))
        elif kind == 2 and len(steps) > 1:
            del steps[one]
        elif kind == 3:
            steps[one] = rng.choice(CODES).encode("latin-1") + rng.bytes(rng.integers(0, 9))
        else:
            steps[one] = steps[one][:1] + EXTREMES[rng.integers(0, len(EXTREMES))] + steps[one][5:]
    return data[:start] + b"".join(steps)


def mutated_npz(data: bytes, rng: np.random.Generator) -> bytes:
    """An npz whose arrays are changed, under checksums that are right."""
    with np.load(io.BytesIO(data), allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
    name = list(arrays)[rng.integers(0, len(arrays))]
    array = arrays[name]
    change: list[Callable[[], np.ndarray]] = [
        lambda: array[:0] if array.ndim else np.zeros(0),
        lambda: array.reshape(-1),
        lambda: array[None],
        lambda: np.asfortranarray(array.T),
        lambda: np.full(array.shape, np.nan),
        lambda: np.full(array.shape, -1e300),
        lambda: np.zeros(array.shape, np.complex128),
        lambda: np.array("text"),
        lambda: np.zeros(array.shape, "datetime64[s]"),
        lambda: np.zeros(array.shape, [("x", "f4"), ("y", "i2")]),
        lambda: np.full(array.shape, 1e30, np.float32),
    ]
    kind = int(rng.integers(0, len(change) + 2))
    if kind < len(change):
        arrays[name] = change[kind]()
    elif kind == len(change):
        del arrays[name]
    members = {f"{key}.npy": _npy(value) for key, value in arrays.items()}
    if kind == len(change) + 1:  # a header that claims far more than there is, or nonsense
        shape = repr(tuple(int(n) for n in 10 ** rng.uniform(0, 7, size=rng.integers(1, 4)))).encode()
        member = members[f"{name}.npy"]
        members[f"{name}.npy"] = member.replace(repr(array.shape).encode(), shape, 1)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for key, content in members.items():
            archive.writestr(key, content)
    return stream.getvalue()


def readers(place: Path) -> Iterator[tuple[str, str, list[bytes], Callable[[Path], object]]]:
    """Name, suffix, whole files and function of each reader."""
    from w2w.scene.motion.importers import check_fbx

    whole = place / "whole.npz"
    rng = np.random.default_rng(0)
    smooth = rng.normal(size=(30, 72)).cumsum(axis=0) / 100
    rate = {"mocap_framerate": np.array(30.0)}
    write_npz(whole, {"poses": smooth, "trans": np.zeros((30, 3)), **rate})
    poses = [whole.read_bytes()]
    parts = {"root_orient": smooth[:, :3], "pose_body": smooth[:, :63], "trans": smooth[:, :3]}
    write_npz(whole, parts | rate)
    poses.append(whole.read_bytes())
    ImuRecording(rng.normal(size=(50, 3, 3)), rng.normal(size=(50, 3, 3)), 50.0, ("a", "b", "c")).save(whole)
    recording = [whole.read_bytes()]
    write_npz(whole, {"features": np.zeros((4, 5, 6), np.float32)})
    labels = b'file,activity,subject\na.fbx,walking,one\n"b, c.fbx","run\nning",two\n'
    for name in ("a.fbx", "b, c.fbx"):
        (place / "library" / name).parent.mkdir(exist_ok=True)
        (place / "library" / name).touch()
    fbx = [path.read_bytes() for path in sorted((DATA / "mixamo").rglob("*.fbx"))[:40:8]]
    maps = [path.read_bytes() for path in sorted(BONE_MAPS.glob("*.json"))]
    result = {"poses": smooth, "trans": smooth[:, :3], "names": ["one", "two"], "fps": np.float32(30)}
    pickled = [pickle.dumps(result, protocol) for protocol in range(pickle.HIGHEST_PROTOCOL + 1)]
    stream = io.BytesIO()
    np.save(stream, np.array(result))
    yield "AMASS npz", ".npz", poses, read_amass
    yield "result pkl", ".pkl", pickled, read_result
    yield "objects npy", ".npy", [stream.getvalue()], read_npy_object
    yield "recording npz", ".npz", recording, ImuRecording.load
    yield "features npz", ".npz", [whole.read_bytes()], _columns
    yield "labels csv", ".csv", [labels], lambda path: read_library(place / "library", path)
    yield "bone map json", ".json", maps, BoneMap.load
    yield "BVH", ".bvh", _bvh_files(), read_bvh
    yield "FBX check", ".fbx", fbx or [b"Kaydara FBX Binary  \0\x1a\0" + bytes(400)], check_fbx


def _bvh_files() -> list[bytes]:
    """Real ones of every program's, with their first frames: most damage is then in the skeleton."""
    folders = sorted(path for path in (DATA / "bvh").iterdir() if path.is_dir()) if DATA.is_dir() else []
    files = [sorted(folder.glob("*.bvh"))[0].read_bytes() for folder in folders]
    return [_first_frames(data, 12) for data in files] or [TWO_BONES]


def _first_frames(data: bytes, frames: int) -> bytes:
    head, motion, rows = data.partition(b"MOTION")
    promise, rate, *rows = [line for line in rows.splitlines() if line.strip()]
    kept = rows[:frames]
    promise = promise.split(b":")[0] + b": %d" % len(kept)
    return head + b"\n".join([motion, promise, rate, *kept, b""])


def fuzz_readers(place: Path, cases: int, seed: int) -> Counter[str]:
    """Damage so many files and read them; how each ended, counted by reader."""
    rng = np.random.default_rng(seed)
    found: Counter[str] = Counter()
    kinds = list(readers(place))
    for number in range(cases):
        name, suffix, files, read = kinds[number % len(kinds)]
        data = files[rng.integers(0, len(files))]
        if suffix == ".npz" and rng.random() < 0.6:
            data = mutated_npz(data, rng)
        elif suffix == ".bvh" and rng.random() < 0.5:
            data = mutated_words(data, rng)
        elif suffix in (".pkl", ".npy") and rng.random() < 0.6:
            data = mutated_steps(data, rng)
        else:
            data = mutated(data, rng, files[rng.integers(0, len(files))])
        path = place / f"case{suffix}"
        path.write_bytes(data)
        try:
            with warnings.catch_warnings(action="error"):
                read(path)
            found[f"{name}: read"] += 1
        except PROMISED:
            found[f"{name}: refused with a sentence"] += 1
        except Exception as error:
            found[f"FAULT {name}: {type(error).__name__}: {error}"] += 1
            (place / f"fault {number}{suffix}").write_bytes(data)
    return found


def _columns(path: Path) -> np.ndarray:
    found = StoredArray.find(path, "features")
    return found.columns([(0, 1)])


def _npy(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.asarray(array), allow_pickle=False)
    return stream.getvalue()


def main() -> None:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    choice = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        found = fuzz_readers(Path(place), choice.cases, choice.seed)
    for name, count in sorted(found.items()):
        print(f"{count:7d}  {name}")
    if any(name.startswith("FAULT") for name in found):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
