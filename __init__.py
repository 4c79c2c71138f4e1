# SPDX-License-Identifier: GPL-3.0-or-later
"""Door of the Blender extension: hands registration on to `blender_addon.w2w`."""

from .blender_addon.w2w import register, unregister

__all__ = ["register", "unregister"]
