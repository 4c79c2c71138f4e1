# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w init`: a file with every option of a run."""

from pathlib import Path
from typing import Annotated

from ...core.files import write_text
from ...core.wording import clean
from ..config_file import template
from ..console import USAGE, Terminal, ending
from ..options import argument
from ..runs.own_files import new_file
from .run import run


def init(file: Annotated[Path, argument("[FILE]", "A new TOML file.")] = Path("study.toml")) -> None:
    """Write every option of a run with its help and default, to change and give to `w2w run --config`.

    Exit codes: 0 written, 2 FILE exists or cannot be written.
    """
    console = Terminal()
    with ending(USAGE, console):
        new_file(file)
        write_text(file, template(run))
    console.print(f"Written: {clean(file)}. Change it, and run w2w run --config {clean(file)}")
