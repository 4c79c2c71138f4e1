# SPDX-License-Identifier: GPL-3.0-or-later
"""What the process's exit code says."""

NOTHING_TO_DO = 1
"""There is no result; a sentence on the screen says why."""

USAGE = 2
"""Wrong arguments, a missing folder, a labels file that cannot be understood."""

SKIPPED = 3
"""Clips were skipped and ``--strict`` was asked for."""

BUSY = 4
"""Another run works in the output folder."""

INTERRUPTED = 130
"""Stopped by Ctrl-C, as shells count it: 128 and the signal's number; so SIGTERM is 143, SIGHUP 129."""
