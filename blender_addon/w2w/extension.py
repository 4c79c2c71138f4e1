# SPDX-License-Identifier: GPL-3.0-or-later
"""Name under which Blender knows the extension, which says it here; the package's own without one."""

NAME = "w2w"
