# SPDX-License-Identifier: GPL-3.0-or-later
"""What importers print stays off the screen, and what a script printed does not."""

import subprocess
import sys

SCRIPT = """
import os
from w2w.core.reading.guard import quiet_output
print("before")
with quiet_output():
    os.write(1, b"an importer")
    print("another")
print("after")
"""


def test_prints_before_and_after_the_import_come_through_a_pipe():
    done = subprocess.run([sys.executable, "-E", "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["before", "after"]
