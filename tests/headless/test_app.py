# SPDX-License-Identifier: GPL-3.0-or-later
"""The help lists every command with its own first line, and imports none of them."""

import subprocess
import sys

import typer
from typer.testing import CliRunner

from w2w.headless.app import APP, first_line

LISTED = """
import sys
from typer.testing import CliRunner
from w2w.headless.app import APP
said = CliRunner().invoke(APP, ["--help"]).output
print(*{"numpy", "scipy", "loky", "w2w.headless.commands.run", "w2w_studies.commands.study"} & {*sys.modules})
"""


def test_the_help_imports_no_command():
    done = subprocess.run([sys.executable, "-c", LISTED], capture_output=True, text=True, check=True)
    assert not done.stdout.strip()


def test_each_line_is_the_first_of_the_commands_own_help():
    group = typer.main.get_command(APP)
    said = CliRunner().invoke(APP, ["--help"], env={"COLUMNS": "200"}).output
    assert {"run", "rank-recordings", "serve", "study"} <= {*group.points}
    for name, point in group.points.items():
        line = first_line(point)
        command = group.get_command(None, name)
        assert line == command.help.partition("\n")[0], name
        assert command.name == name
        assert line.replace("`", "").replace("*", "") in said, name
