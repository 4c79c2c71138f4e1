# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests mirror the packages: what w2w/core/imu does is tested in tests/core/imu, the studies beside them."""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TESTS_OF = {
    Path("blender_addon/w2w"): Path("tests"),
    Path("packages/studies/w2w_studies"): Path("packages/studies/tests"),
}
TOGETHER = ("tests/scene", "tests/ui")
"""Folders of tests for all packages of a package."""
OF_NO_PACKAGE = {ROOT / "tests/gui"}
"""Clicks in Blender's own window."""


def _folder_of_tests(tests: Path) -> Path:
    """A package's own folder of tests, or the one it shares."""
    return tests.parent if str(tests.parent) in TOGETHER and not (ROOT / tests).is_dir() else tests


PACKAGES = [
    (package.parent, _folder_of_tests(tests / package.parent.relative_to(ROOT / root)))
    for root, tests in TESTS_OF.items()
    for package in sorted((ROOT / root).rglob("__init__.py"))
    if any(package.parent.glob("[!_]*.py"))
]


@pytest.mark.parametrize(("package", "tests"), PACKAGES, ids=[str(tests) for _, tests in PACKAGES])
def test_every_package_has_tests(package, tests):
    assert any((ROOT / tests).glob("test_*.py")), f"write tests of {package.relative_to(ROOT)} in {tests}"


def test_every_folder_of_tests_is_of_a_package():
    """A package that moved takes its tests with it."""
    ours = {ROOT / tests for _, tests in PACKAGES} | OF_NO_PACKAGE
    strays = {test.parent for root in TESTS_OF.values() for test in (ROOT / root).rglob("test_*.py")} - ours
    assert not strays, f"tests of no package: {', '.join(str(folder.relative_to(ROOT)) for folder in strays)}"
