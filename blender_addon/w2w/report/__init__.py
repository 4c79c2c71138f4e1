# SPDX-License-Identifier: GPL-3.0-or-later
"""The report: a finished study as one page for any browser; never imports Blender."""
