# SPDX-License-Identifier: GPL-3.0-or-later
"""Heatmaps on the body as pictures: no Blender, no window."""
