# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies of W2W: comparisons with public data sets, the paper's studies, sweeps, experiments."""
