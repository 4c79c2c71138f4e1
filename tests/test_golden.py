# SPDX-License-Identifier: GPL-3.0-or-later
"""Each stage makes what its version made: runs keep results by these versions, not by the code's text."""

import json
from pathlib import Path

import pytest

from .golden import GOLDEN, VERSIONS, complaint, outcome


@pytest.fixture(scope="module")
def made(made_once):
    """What each stage makes now."""

    def make(folder: Path) -> None:
        (folder / "made.json").write_text(json.dumps(outcome(folder)))

    return json.loads((made_once("golden", make) / "made.json").read_text())


@pytest.mark.parametrize("stage", VERSIONS)
def test_a_stage_makes_what_its_version_made(made, stage):
    assert not (why := complaint(stage, made[stage], json.loads(GOLDEN.read_text()))), why


@pytest.mark.parametrize(
    ("stage", "name", "by"),
    [
        ("signals", "motion poses", 1e-5),
        ("signals", "signals acc", 0.5),
        ("signals", "features", 0.01),
        ("ranking", "ranking f1", 0.02),
        ("ranking", "chosen", 1),
    ],
)
def test_a_change_without_a_new_version_says_what_to_do(stage, name, by):
    known = json.loads(GOLDEN.read_text())
    found = known[stage]["digests"] | {name: [value + by for value in known[stage]["digests"][name]]}
    said = complaint(stage, found, known)
    assert f"({name})" in said
    assert f"raise {stage.upper()}_VERSION in core/study/{stage}.py" in said
    assert not complaint(stage, known[stage]["digests"], known)


def test_a_raised_version_asks_for_new_digests():
    known = json.loads(GOLDEN.read_text())
    known["ranking"]["version"] = [1, 0]
    assert "python -m tests.golden" in complaint("ranking", known["ranking"]["digests"], known)
