# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages of the site that are made from the code: the command line's, and the list of what `w2w` offers."""

import os
import re
import subprocess
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
BIN = ROOT / ".venv" / "bin"

LINK = re.compile(r"\[([^\]]+)\]\(((?:\.\./)+)[^)]*\)")
"""A link to a folder above the page's own."""

OFFERED = "import w2w; print(*(name for name in w2w.__all__ if name[0] != '_'))"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add both pages."""
    files.append(File.generated(config, "command_line.md", content=_command_line()))
    files.append(File.generated(config, "api.md", content=_api()))
    return files


def on_page_markdown(markdown: str, page: Page, **_: object) -> str:
    """Name files of the code where a document links to them: the site does not hold them."""
    inside = 3 * page.file.src_uri.count("/")

    def shown(link: re.Match[str]) -> str:
        return link[1] if len(link[2]) > inside else link[0]

    return LINK.sub(shown, markdown)


def _command_line() -> str:
    """What every `--help` says, as typer writes it."""
    app = ("--app", "APP", "w2w.headless.app")
    return _said("typer", *app, "utils", "docs", "--name", "w2w", "--title", "Command line")


def _api() -> str:
    names = _said("python", "-c", OFFERED).split()
    title = "# Python\n\nEverything that `import w2w` offers; [a short course](python.md) comes first."
    listed = [*(f"w2w.{name}" for name in names), "w2w.core.imu.sensor.Triad"]
    return "\n\n".join([title, *(f"::: {name}" for name in listed)])


def _said(program: str, *arguments: str) -> str:
    command = [BIN / program, *arguments]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True, check=True).stdout
