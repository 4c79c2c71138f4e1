# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m headless ...` in the source tree: the `w2w` command."""

import sys

if __name__ == "__main__":
    if not sys.flags.safe_path:
        del sys.path[0]  # the current directory: whatever lies there is none of our modules
    from pathlib import Path

    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "blender_addon"))
    from w2w.headless.start import main

    main()
