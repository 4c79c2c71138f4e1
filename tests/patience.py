# SPDX-License-Identifier: GPL-3.0-or-later
"""How long tests wait for other processes."""

HANG_S = 300.0
"""Seconds after which something hangs: no busy machine takes so long, and no test is about speed."""
