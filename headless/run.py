# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --background --python headless/run.py -- LIBRARY --out OUT`: `w2w run` by its path."""

import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "blender_addon"))
    from w2w.headless.start import run_script

    run_script("run")
