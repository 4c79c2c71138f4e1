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


ELSEWHERE = {
    "api": "examples rank ranked signals",
    "": "command_line extension",
    "core/adopt": "rest_pose topology",
    "core/body": "landmarks region_names",
    "core/exports": "arrays biomechanics pose_packs study_signals",
    "core/findings": "advice_content new_folder notes",
    "core": "pickles stand_ins",
    "core/imu": "clock errors sensor_fields vendor_formats",
    "core/keypoints": "joint_sets naming paths",
    "core/motion": "shared_stretches sight source",
    "core/ranking/classifiers": "estimator",
    "core/readers": "import_checks",
    "core/reading": "worker",
    "core/retargeting": "limb_joints repair",
    "core/selection": "scored",
    "core/study": "config signals variants",
    "drawing": "signal_figure",
    "headless": "options",
    "headless/commands": "demo execute init report sensors status",
    "headless/reports": "console_tables",
    "headless/runs": "clip study",
    "scene/base": "fcurves module patches playback",
    "scene/files": "study_file",
    "scene/motion": "load",
    "ui/jobs": "text windows",
    "ui/panels": "base placement properties results rows sensor top wearing",
    "ui/results": "results",
    "ui/steps": "body motions patches",
    "ui/study": "lists operators pages scores sensors signal_cache state",
    "ui/viewport": "drawing overlay places",
    "web": "answers receiving request study",
}
"""Modules whose tests lie where no name says it, by their room: it may only shrink."""


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


def test_a_modules_test_is_where_its_name_says():
    root, named = ROOT / "blender_addon/w2w", set()
    for module in root.rglob("*.py"):
        room = module.parent.relative_to(root)
        folders = (Path("tests") / room, _folder_of_tests(Path("tests") / room))
        if any((ROOT / folder / f"test_{module.name}").is_file() for folder in folders):
            named.add(room / module.stem)
    modules = {module.relative_to(root).with_suffix("") for module in root.rglob("[!_]*.py")}
    presets = {module for module in modules if "presets" in module.parts}
    elsewhere = {Path(room, name) for room, names in ELSEWHERE.items() for name in names.split()}
    without = modules - presets - named
    assert not without - elsewhere, "call its test tests/<room>/test_<module>.py"
    assert not elsewhere - without, "these have one, or are gone: take them from the list"
