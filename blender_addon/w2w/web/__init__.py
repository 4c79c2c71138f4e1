# SPDX-License-Identifier: GPL-3.0-or-later
"""The web app of `w2w serve`: drop clips in a browser, get the answer."""
