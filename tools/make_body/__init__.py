# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the bundled body from MakeHuman's CC0 data: `python -m tools.make_body`."""
