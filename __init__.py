# SPDX-License-Identifier: GPL-3.0-or-later
"""Door of the Blender extension: hands registration on to `w2w`."""

if __package__:  # else it is pytest that looks in, from a folder whose name is no Python name
    from .blender_addon.w2w import register, unregister

__all__ = ["register", "unregister"]
