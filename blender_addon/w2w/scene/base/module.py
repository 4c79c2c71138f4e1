# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Python module, which the rest of `scene` imports from here.

As Blender starts, its sound library runs each shared library in a folder `plugins` of the current directory,
so that is another one meanwhile.
"""

import sys
from contextlib import chdir, nullcontext
from pathlib import Path

with nullcontext() if "bpy" in sys.modules else chdir(Path(__file__).parent):
    import bpy as bpy
