# SPDX-License-Identifier: GPL-3.0-or-later
"""Classifiers under one interface: all sensors trained together, each on its own signals."""
