# SPDX-License-Identifier: GPL-3.0-or-later
"""The packages of `w2w`; everything else of the build is in `pyproject.toml`."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages("blender_addon"), "w2w.templates"],
    package_dir={"": "blender_addon", "w2w.templates": "assets/templates"},
)
