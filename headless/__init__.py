# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W's command line, imported as `w2w.headless`; in the source tree `w2w` is in `blender_addon`."""

import sys

if sys.argv[:1] == ["-m"] and not sys.flags.safe_path:
    del sys.path[0]  # the current directory: whatever lies there is none of our modules

from pathlib import Path

_TREE = Path(__file__).resolve().parents[1] / "blender_addon"
if (_TREE / "w2w").is_dir() and str(_TREE) not in sys.path:
    sys.path.insert(0, str(_TREE))  # first: the index has another package of this name
