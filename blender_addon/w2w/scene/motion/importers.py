# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's importers: FBX and USD files are checked before, glTF and VRM made ready for them."""

import math
import re
import struct
import sys
import tempfile
from pathlib import Path
from typing import Any

from ...core.motion.sight import UPS, Up
from ...core.motion.source import SAY_RATE, UnusableMotion, size_and_head
from ...core.readers.import_checks import VRM_SUFFIXES, check_gltf, with_skin
from ...core.wording import restated
from ..base.actions import set_scene_rate
from ..base.module import bpy, import_from

FBX_MAGIC = b"Kaydara FBX Binary  \x00\x1a\x00"
FBX_HEADER_SIZE = 27

OLDEST = 3000
"""FBX 3.0: the oldest version that Blender's C++ importer (4.5 and later) reads, as text too."""

OLDEST_FOR_PYTHON = 7100
"""FBX 2011: the oldest version, and binary only, that the Python importer before it reads."""

GLTF_RATE = 60.0
"""Frames per second at which glTF files are read: they have times, no rate."""

MANY_KEYS, A_SECOND_APART = 20, 1.05
"""More keys, in its densest channel, at fewer a second are frames of a writer that knew no rate."""

FBX_UP = re.compile(
    rb'"UpAxis",[^\n]*?([012])\s*\n|'
    rb"UpAxisS\x03\0\0\0intS(?:\x07\0\0\0Integer|\0\0\0\0)S\0\0\0\0I(.)",
    re.DOTALL,
)
"""The line of the header, as text or binary, that names the axis that is up by its number."""

SAVE_ANEW = "save it as FBX 7.4 (FBX 2014), binary, where it comes from or with Blender 4.5 or later"

FAULTS = {
    "memory": "it unpacks to more than fits in memory",
    "truncated": "it is cut short, or a record in it does not add up",
    "failed to read": "it is cut short, or a record in it does not add up",
    "deflate": "it is damaged: a packed part of it cannot be unpacked",
    "ascii parse": "it is damaged: its text cannot be understood",
}
"""Words in the messages of Blender's importers, in lower case, and what they mean."""


def check_fbx(path: Path, python_importer: bool = False) -> None:
    """Refuse a file that Blender cannot read as FBX, with a sentence that is true.

    It may be empty, a Git LFS pointer, cut short, no FBX at all, or of a version that Blender does not read;
    `python_importer` says that it has only the importer from before 4.5.
    """
    size, head = size_and_head(path)
    binary = head.startswith(FBX_MAGIC)
    if binary:
        _check_binary_fbx(path, size, head)
    elif b"FBX" not in head:
        raise UnusableMotion("it is not an FBX file: neither the binary mark nor FBX text is at its start")
    version = _version(head)
    if version is not None and version < OLDEST:
        raise UnusableMotion(
            f"its header says FBX version {_spoken(version)}, and Blender reads 3.0 and later: it is "
            f"damaged, or very old; {SAVE_ANEW}"
        )
    if python_importer and (not binary or (version or 0) < OLDEST_FOR_PYTHON):
        kind = "" if version is None else f" of version {_spoken(version)}"
        form = "" if binary else " in text form"
        raise UnusableMotion(f"it is an FBX{kind}{form}, which Blender reads from 4.5 on: {SAVE_ANEW}")


def fbx_up(path: Path) -> Up:
    """The axis that an FBX file's header calls up, by default y."""
    found = FBX_UP.search(path.read_bytes())
    axis = 1 if found is None else int(found[1]) if found[1] else found[2][0]
    return UPS[axis] if axis in range(3) else "y"


def import_fault(path: Path, error: Exception) -> str:
    """A sentence for people about why Blender's importer refused a file that looked whole."""
    message = str(error).replace(str(path), "").lower()
    fault = next((fault for words, fault in FAULTS.items() if words in message), "")
    version = _version(size_and_head(path)[1]) if path.suffix.lower() == ".fbx" else None
    if version is not None and version < OLDEST_FOR_PYTHON and not fault.endswith("memory"):
        return (
            f"Blender cannot import it: it is an FBX of version {_spoken(version)}, from before 2011, or it "
            f"is damaged; if it opens elsewhere, {SAVE_ANEW}"
        )
    return f"Blender cannot import it: {fault or 'it is damaged'}"


def _version(head: bytes) -> int | None:
    """The version, such as 7400 for FBX 7.4; None if the start of a text file does not say."""
    if head.startswith(FBX_MAGIC):
        return struct.unpack_from("<I", head, 23)[0]
    version = re.search(rb"FBXVersion:\s*(\d{1,5})\b", head)
    return int(version[1]) if version else None


def _spoken(version: int) -> str:
    return f"{version / 1000:.1f}"


def _check_binary_fbx(path: Path, size: int, head: bytes) -> None:
    """Follow the top-level records: each tells where it ends, and the file must reach there."""
    if size <= FBX_HEADER_SIZE:
        raise UnusableMotion(f"it is cut short: {size} bytes, no more than the header of an FBX file")
    version = struct.unpack_from("<I", head, 23)[0]
    layout = "<Q" if version >= 7500 else "<I"
    position = FBX_HEADER_SIZE
    with path.open("rb") as stream:
        while True:
            stream.seek(position)
            field = stream.read(struct.calcsize(layout))
            if len(field) < struct.calcsize(layout):
                raise UnusableMotion(f"it is cut short at {size} bytes: its list of records has no end")
            end = struct.unpack(layout, field)[0]
            if end == 0:
                return
            if end > size:
                raise UnusableMotion(
                    f"it is cut short, or damaged: a record should end at byte {end:,}, and the file ends at "
                    f"{size:,}"
                )
            if end <= position:
                raise UnusableMotion(f"it is damaged: the record at byte {position} ends before it begins")
            position = end


def import_gltf(path: Path, keys_as_frames: bool = False, animation: str = "") -> None:
    """Import a glTF or VRM file into the open scene, finely enough for its key times, or a key a frame.

    Of its animations one is imported if it is named. Refused are files that are damaged, of another version,
    in several parts, or no VRM though named as one.
    """
    is_vrm, facts = path.suffix.lower() in VRM_SUFFIXES, check_gltf(path, animation)
    if not keys_as_frames and facts.keys >= MANY_KEYS and facts.keys_a_second < A_SECOND_APART:
        raise UnusableMotion(
            f"its {facts.keys} keys are a second apart, which looks like frames without a rate: give it "
            f"({SAY_RATE})"
        )
    set_scene_rate(facts.keys_a_second if keys_as_frames else GLTF_RATE)
    with tempfile.TemporaryDirectory() as folder:
        file = path
        if is_vrm or animation or not facts.skin:
            file = Path(folder, "skinned.glb" if is_vrm else f"skinned{path.suffix}")
            file.write_bytes(with_skin(path, animation))
        bpy.ops.import_scene.gltf(filepath=str(file))


MAGICS = (b"#usda 1.", b"PXR-USDC", b"PK\x03\x04")
"""How text, binary and archive begin."""

FALLBACK_RATE = 24.0
"""Time codes a second if the file does not give them, by USD's own rule."""


def import_usd(path: Path) -> None:
    """Import a USD file, text or binary, at its own time codes a second, which Blender's importer ignores.

    Refused are files that are damaged or put together from others, and a Blender that knows no USD.
    """
    if "usd_import" not in dir(bpy.ops.wm):
        raise UnusableMotion("this Blender was built without USD: export the file as .glb or FBX")
    open_library()
    set_scene_rate(usd_rate(path))
    # what else would be read from beside it: textures, lights' pictures and volumes
    bpy.ops.wm.usd_import(
        filepath=str(path), import_materials=False, import_lights=False, import_volumes=False
    )


def open_library() -> None:
    """Let Python import USD's library, which Blender's module has off the path (4.4 and later)."""
    if bpy.app.module and "pxr" not in sys.modules:
        import_from(map(str, Path(bpy.__file__).parents[3].glob("python/lib/**/site-packages")), "pxr")


def usd_rate(path: Path) -> float:
    """Time codes a second of a USD file; one that is damaged or put together from other files is refused.

    Raises UnusableMotion, with the reason. No other file is opened.
    """
    if not size_and_head(path)[1].startswith(MAGICS):
        raise UnusableMotion("it is damaged or no USD file: it does not begin as one")
    try:
        from pxr import Sdf, Tf
    except ImportError:
        raise UnusableMotion(
            "whether other files are part of it cannot be seen here: use Blender 4.4 or later, or export it "
            "as .glb or FBX"
        ) from None
    with restated("it is damaged: USD cannot read it", Tf.ErrorException, UnusableMotion):
        layer = Sdf.Layer.OpenAsAnonymous(str(path))
    if layer is None:
        raise UnusableMotion("it is damaged: USD cannot read it")
    if part := next(filter(None, layer.GetCompositionAssetDependencies()), "") or _clips(layer):
        raise UnusableMotion(f"parts of it lie in other files ({part[:60]}): save it as one file, flattened")
    if layer.HasTimeCodesPerSecond():
        return _rate(layer.timeCodesPerSecond)
    return _rate(layer.framesPerSecond) if layer.HasFramesPerSecond() else FALLBACK_RATE


def _clips(layer: Any) -> str:
    """A prim whose values lie in other files, over time and without a reference (value clips); or ""."""
    found = list[str]()

    def look(path: Any) -> None:
        spec = layer.GetPrimAtPath(path)
        if spec is not None and spec.HasInfo("clips"):
            found.append(f"clips of {path}")

    layer.Traverse("/", look)
    return "".join(found[:1])


def _rate(rate: float) -> float:
    if not (math.isfinite(rate) and rate > 0):
        raise UnusableMotion(f"it is damaged: it has {rate:g} time codes a second")
    return rate
