# SPDX-License-Identifier: GPL-3.0-or-later
"""Redirection of what Blender and its importers print."""

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def output_to(path: Path) -> Iterator[None]:
    """Write what the process prints to a file, C++ included, even when it dies."""
    with path.open("w") as file:
        sys.stdout.flush()  # what was printed before is the user's
        saved = [os.dup(1), os.dup(2)]
        try:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
            yield
        finally:
            sys.stdout.flush()  # into a pipe it would come out later
            for number, handle in enumerate(saved, start=1):
                os.dup2(handle, number)
                os.close(handle)


def quiet_output() -> contextlib.AbstractContextManager[None]:
    """Keep what Blender's importers print from the user's screen."""
    return output_to(Path(os.devnull))
