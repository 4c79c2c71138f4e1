# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's importers: FBX and USD files are checked before, glTF and VRM made ready for them."""

import math
import re
import struct
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...core.motion.sight import UPS, Up
from ...core.motion.source import SAY_RATE, UnusableMotion, size_and_head
from ...core.readers.import_checks import VRM_SUFFIXES, check_gltf, with_skin
from ...core.wording import restated
from ..base.actions import set_scene_rate
from ..base.body import read_values
from ..base.fcurves import action_curves, curves_by_owner, rescale, slot_named_for
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


LEAST = 0.01
"""Smallest relative difference in size that counts."""

SCALING = re.compile(
    rb'Lcl Scaling(?:"(?:,\s*"[^"\n]*"){1,3},(?P<numbers>[-+.,\deE\s]{5,200})|'
    rb"S\x0b\0\0\0Lcl Scaling(?:S.\0\0\0[A-Z+]{0,3}){1,2}(?P<doubles>D.{8}D.{8}D.{8}))",
    re.DOTALL,
)
"""The scale of a node against its parent, as text or binary; it begins as fast searches want."""

TEXT_NAME = re.compile(rb'Model:\s*(?:\d+,\s*)?"(?:Model::)?([^"\n]{1,500})"')
BINARY_NAME = re.compile(rb"\x05Model(?:L.{8})?S.{4}([^\x00]{1,500})\x00\x01Model", re.DOTALL)
"""Where a node begins, with its name."""


def node_sizes(path: Path) -> dict[str, float]:
    """The scale of each node of an FBX file against its parent, by its name, where it has one."""
    sizes: dict[str, float] = {}
    content = path.read_bytes()
    for found in SCALING.finditer(content):
        doubles, numbers = found["doubles"], (found["numbers"] or b"").split(b",")
        if not doubles and len(numbers) != 3:
            continue
        scale = struct.unpack("<xdxdxd", doubles) if doubles else [float(number) for number in numbers]
        size = float(_sizes(np.array([scale]))[0])
        if abs(size - 1) > LEAST:
            start = content.rfind(b"\x05Model" if doubles else b"Model: ", 0, found.start())
            if start >= 0 and (name := (BINARY_NAME if doubles else TEXT_NAME).match(content, start)):
                sizes[name[1].decode("utf-8", "replace")] = size
    return sizes


def are_scaled(imported: Iterable[bpy.types.ID], nodes: Mapping[str, float]) -> bool:
    """Whether bones of what came from a file are scaled, by their poses or their nodes."""
    return any(
        not nodes.keys().isdisjoint(armature.pose.bones.keys())
        or bool((np.abs(_pose_sizes(armature) - 1) > LEAST).any())
        for armature in _armatures(imported)
    )


def bind_sizes(still: Iterable[bpy.types.ID], nodes: Mapping[str, float]) -> dict[str, float]:
    """The size of each bone's bind pose in its armature, by its name, from an import without animation."""
    sizes = {"": 1.0}
    for armature in _armatures(still):
        for bone, pose in zip(armature.pose.bones, _pose_sizes(armature).tolist(), strict=True):
            parent = sizes[bone.parent.name if bone.parent else ""]  # which comes before its children
            sizes[bone.name] = parent * nodes.get(bone.name, 1.0) / pose
    return sizes


def mend_places(imported: Iterable[bpy.types.ID], sizes: Mapping[str, float]) -> None:
    """Put the places to which bones are keyed in the size of their bind poses."""
    imported = list(imported)
    actions = [item for item in imported if isinstance(item, bpy.types.Action)]
    for armature in _armatures(imported):
        for action in actions:
            slot = slot_named_for(armature, action)
            curves = next(action_curves(action, slot), []) if slot else []
            for bone, own_curves in curves_by_owner(armature, curves).items():
                for (channel, _), curve in own_curves.items():
                    if bone and channel == "location" and abs(sizes[bone] - 1) > LEAST:
                        rescale(curve, 1, sizes[bone], 0.0)


def _armatures(items: Iterable[bpy.types.ID]) -> Iterator[bpy.types.Object]:
    return (item for item in items if isinstance(item, bpy.types.Object) and item.type == "ARMATURE")


def _pose_sizes(armature: bpy.types.Object) -> np.ndarray:
    bones = armature.pose.bones
    return _sizes(read_values(bones, "scale", 3 * len(bones), np.float32).reshape(-1, 3))


def _sizes(scales: np.ndarray) -> np.ndarray:
    """One size (B,) for scales (B, 3) along three axes; 1 where there is none."""
    product = np.abs(scales.astype(np.float64)).prod(axis=1)
    return np.where((product > 0) & (product < np.inf), np.cbrt(product), 1.0)
