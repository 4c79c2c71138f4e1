# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages of the site that are made from the code: the command line's, and the list of what `w2w` offers."""

import os
import re
import subprocess
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
BIN = ROOT / ".venv" / "bin"

OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./[^)]*\)")
"""A link out of the documents' folder."""

OFFERED = "import w2w; print(*(name for name in w2w.__all__ if name[0] != '_' and 'register' not in name))"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add both pages."""
    files.append(File.generated(config, "command_line.md", content=_command_line()))
    files.append(File.generated(config, "api.md", content=_api()))
    return files


def on_page_markdown(markdown: str, **_: object) -> str:
    """Name files of the code where a document links to them: the site does not hold them."""
    return OUTSIDE.sub(r"\1", markdown)


def _command_line() -> str:
    """What every `--help` says, as typer writes it."""
    return _said(
        "typer", "--app", "APP", "headless.app", "utils", "docs", "--name", "w2w", "--title", "Command line"
    )


def _api() -> str:
    names = _said("python", "-c", OFFERED).split()
    title = "# Python\n\nEverything that `import w2w` offers; [a short course](python.md) comes first."
    return "\n\n".join([title, *(f"::: w2w.{name}" for name in names)])


def _said(program: str, *arguments: str) -> str:
    command = [BIN / program, *arguments]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, check=True).stdout
