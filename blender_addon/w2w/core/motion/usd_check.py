# SPDX-License-Identifier: GPL-3.0-or-later
"""Check a USD file before Blender imports it, and read its frame rate, which Blender ignores."""

from __future__ import annotations

import math
import re
from pathlib import Path

from .motion_file import size_and_head
from .source import UnusableMotion

USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")

TEXT, CRATE, ARCHIVE = b"#usda 1.", b"PXR-USDC", b"PK\x03\x04"
"""How its three forms begin."""

FALLBACK_RATE = 24.0
"""Time codes a second where the file does not say, by USD's own rule."""

MAX_TEXT_BYTES = 512 * 2**20

HEADER = re.compile(rb"#usda 1\.\d\s*\((?P<header>.*?)^\)", re.DOTALL | re.MULTILINE)
COMPOSED = re.compile(rb"\b(?:subLayers|references|payload)\s*=[^@\n]*(?:\n[^@\n]*)?@(?P<asset>[^@\n]+)@")

HOW_TO_READ = "use Blender 4.4 or later, or save it as text, .usda"


def check_usd(path: Path) -> float:
    """Time codes a second of a USD file; one that is damaged or put together from other files is refused.

    Raises UnusableMotion, with the reason.
    """
    size, head = size_and_head(path)
    if head.startswith(TEXT):
        if size > MAX_TEXT_BYTES:
            raise UnusableMotion("it is too large for a USD file in text form: save it as .usdc")
        return _of_text(path.read_bytes())
    if not head.startswith((CRATE, ARCHIVE)):
        raise UnusableMotion("it is damaged or no USD file: it does not begin as one")
    return _by_usd(path)


def _of_text(text: bytes) -> float:
    if found := COMPOSED.search(text):
        _refuse_parts(found["asset"].decode("utf-8", "replace"))
    header = HEADER.match(text)
    if header is None:
        if not text.rstrip().endswith((b"}", b")")):
            raise UnusableMotion("it is cut short")
        return FALLBACK_RATE
    if not text.rstrip().endswith(b"}"):
        raise UnusableMotion("it is cut short")
    for name in (rb"timeCodesPerSecond", rb"framesPerSecond"):
        if found := re.search(rb"^\s*" + name + rb"\s*=\s*(\S+)", header["header"], re.MULTILINE):
            return _rate(found[1].decode("ascii", "replace"))
    return FALLBACK_RATE


def _by_usd(path: Path) -> float:
    """Binary forms, read by USD's own library, which Blender brings."""
    try:
        from pxr import Sdf, Tf
    except ImportError:
        raise UnusableMotion(
            f"it is USD in binary form, whose frames a second cannot be read here: {HOW_TO_READ}"
        ) from None
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path))
    except Tf.ErrorException as error:
        raise UnusableMotion("it is damaged: USD cannot read it") from error
    if layer is None:
        raise UnusableMotion("it is damaged: USD cannot read it")
    if parts := [part for part in layer.GetCompositionAssetDependencies() if part]:
        _refuse_parts(parts[0])
    if layer.HasTimeCodesPerSecond():
        return _rate(layer.timeCodesPerSecond)
    return _rate(layer.framesPerSecond) if layer.HasFramesPerSecond() else FALLBACK_RATE


def _refuse_parts(part: str) -> None:
    raise UnusableMotion(f"parts of it lie in other files ({part[:60]}): save it as one file, flattened")


def _rate(value: str | float) -> float:
    try:
        rate = float(value)
    except ValueError:
        rate = math.nan
    if not (math.isfinite(rate) and rate > 0):
        raise UnusableMotion(f"it is damaged: it has {str(value)[:20]} time codes a second")
    return rate
