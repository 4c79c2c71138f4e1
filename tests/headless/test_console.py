# SPDX-License-Identifier: GPL-3.0-or-later
"""What others named is printed as text: a terminal obeys nothing in it, and nothing in it is markup."""

import io
import re
import subprocess
import sys
from pathlib import Path

import pytest
from rich.table import Table
from typer.testing import CliRunner

from w2w.headless.app import APP
from w2w.headless.console import Terminal

from ..command_line import cli

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")

ROOT = Path(__file__).resolve().parents[2]
TITLE = "\x1b]0;pwned\x07\x1b[2J"
OBEYED = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")


def test_a_terminal_gets_its_own_styles_and_no_command_of_a_text():
    console = Terminal(file=io.StringIO(), force_terminal=True, width=200)
    console.print(f"{TITLE}[bold]walk[/] :smile:", style="red")
    table = Table(title=f"title{TITLE}")
    table.add_column(TITLE)
    table.add_row(f"[/]{TITLE}")
    console.print(table)
    written = console.file.getvalue()
    assert "\x1b[31m%1B]0;pwned%07%1B[2J[bold]walk[/] :smile:\x1b[0m" in written
    assert not OBEYED.search(re.sub("\x1b\\[[0-9;]*m", "", written))


@pytest.mark.slow
@pytest.mark.usefixtures("one_worker")
def test_nothing_of_a_library_reaches_the_terminal_as_a_command(motions, tmp_path):
    (motions / "slow").rename(motions / f"slow{TITLE}")
    clips = sorted(motions.rglob("*.npz"))
    clips[0].rename(clips[0].with_name(f"one{TITLE}\n\u202e[red].npz"))
    bone = f"HIERARCHY\nROOT {TITLE}\n{{\n OFFSET 0 0\n"
    (motions / "fast" / f"{TITLE}.bvh").write_text(bone)
    arguments = ["run", motions, "--out", tmp_path / "out", "--patches", "8", "--no-pictures", "--verbose"]
    arguments += ["--workers", "1", "--max", "1"]
    ended = CliRunner().invoke(APP, [str(argument) for argument in arguments])
    assert ended.exit_code == 0, ended.output
    assert "slow%1b]0;pwned%07%1b[2j 4" in ended.output
    assert not OBEYED.search(ended.output)
    labels = tmp_path / f"labels{TITLE}.csv"
    rows = [f'{path.name},"w{TITLE}{path.parent.name[:4]}","{TITLE}"' for path in clips[1:]]
    labels.write_text("\n".join(["file,activity,subject", f"none{TITLE},walk,", *rows, ""]))
    ended = CliRunner().invoke(APP, [str(argument) for argument in [*arguments, "--labels", labels]])
    assert ended.exit_code == 0, ended.output
    assert "w%1B]0;pwned%07%1B[2Jslow 4" in ended.output
    assert not OBEYED.search(ended.output)
    for file in motions.rglob("*.bvh"):
        ended = CliRunner().invoke(APP, ["inspect", str(file)])
        assert ended.exit_code == 1
        assert "%1B]0;pwned%07%1B[2J.bvh would be skipped" in ended.output
        assert not OBEYED.search(ended.output)


ARGUMENTS = [["inspect", TITLE], ["inspect", "a", TITLE], ["run", "--labels", TITLE, "."]]


@pytest.mark.parametrize("arguments", ARGUMENTS)
def test_nothing_of_an_argument_does(arguments):
    code, said = cli(*arguments)
    assert code in (1, 2)
    assert not OBEYED.search(said), said


@pytest.mark.slow
@pytest.mark.parametrize("arguments", ARGUMENTS)
def test_nothing_of_an_argument_does_in_a_program(arguments):
    command = [sys.executable, "-c", "from w2w.headless.start import main; main()", *arguments]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode in (1, 2)
    assert not OBEYED.search(done.stdout + done.stderr), done.stdout + done.stderr
