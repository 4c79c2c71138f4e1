# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line, called in the tests' own process."""

from typer.testing import CliRunner

from w2w.headless.app import APP


def cli(*words: object) -> tuple[int, str]:
    """Exit code and words of a command, which ends without a traceback."""
    done = CliRunner().invoke(APP, [str(word) for word in words], env={"COLUMNS": "1000"})
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    assert "Traceback" not in done.output
    return done.exit_code, " ".join(done.output.split())
