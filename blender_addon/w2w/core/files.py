# SPDX-License-Identifier: GPL-3.0-or-later
"""Write files whole or not at all, with the same bytes for the same content."""

from __future__ import annotations

import hashlib
import io
import json
import os
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)
"""Time stamp of every member of an npz, so that equal arrays give equal bytes."""

DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))}
"""Names that Windows keeps for devices, in lower case: no file can bear one, whatever its ending."""

UNFINISHED = ".w2w.part"
"""How the name of a half-written file ends; nobody else's does."""


@contextmanager
def atomic_write(path: str | Path) -> Iterator[BinaryIO]:
    """Open a temporary file beside `path` and rename it to `path` when all went well.

    Parameters
    ----------
    path : str or Path
        Where the file shall stand; its folder must exist.

    Yields
    ------
    BinaryIO
        The temporary file, opened for writing in binary mode.
    """
    path = Path(path)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:40]}.", suffix=UNFINISHED)
    try:
        Path(temporary).chmod(0o666 & ~_umask())
        with os.fdopen(handle, "wb") as stream:
            yield stream
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def write_npz(path: str | Path, arrays: Mapping[str, Any], compress: bool = False) -> None:
    """Write arrays to an npz file, atomically and with reproducible bytes.

    Parameters
    ----------
    path : str or Path
    arrays : mapping of str to array_like
        No object arrays.
    compress : bool
        Deflate the members; slower to write, smaller on disk.
    """
    method = zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED
    with atomic_write(path) as stream, zipfile.ZipFile(stream, "w", method) as archive:
        for name, value in arrays.items():
            buffer = io.BytesIO()
            np.lib.format.write_array(buffer, np.asanyarray(value), allow_pickle=False)
            info = zipfile.ZipInfo(f"{name}.npy", ZIP_EPOCH)
            info.compress_type = method
            archive.writestr(info, buffer.getvalue())


def write_json(path: str | Path, content: Any) -> None:
    """Write indented UTF-8 JSON atomically; refuses NaN and infinities."""
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    write_text(path, text + "\n")


def write_text(path: str | Path, text: str) -> None:
    r"""Write UTF-8 text atomically, with the line ends as they stand in `text`.

    What is no Unicode is written as ``\udce9``: one odd file name must not cost a whole result.
    """
    with atomic_write(path) as stream:
        stream.write(text.encode("utf-8", "backslashreplace"))


def reserved(name: str) -> bool:
    """Whether Windows would take a file name for a device, as it does ``aux.npz``."""
    return name.split(".")[0].strip().lower() in DEVICES


def file_sha256(path: str | Path) -> str:
    """SHA-256 of a file's bytes, in hexadecimal."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
