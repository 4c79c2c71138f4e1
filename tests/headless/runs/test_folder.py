# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept of a run is made anew by other templates and versions, and by nothing else."""

import json
import shutil

import pytest

from w2w.core.body.body import TEMPLATES
from w2w.headless.runs import folder

MADE_BY = (folder.signals_made_by.__wrapped__, folder.results_made_by.__wrapped__)


@pytest.fixture
def templates(tmp_path, monkeypatch):
    monkeypatch.setattr(folder, "TEMPLATES", tmp_path / "templates")
    return shutil.copytree(TEMPLATES, tmp_path / "templates")


@pytest.mark.parametrize(
    ("file", "anew"),
    [
        ("products.json", [False, True]),  # a product by another name
        ("sensors.json", [False, True]),  # the study's sensor is a parameter
        ("bone_maps/mixamo.json", [True, True]),
        ("joint_sets.json", [True, True]),
        ("parquet_card.md", [False, False]),
    ],
)
def test_a_template_counts_by_its_content(templates, file, anew):
    before = [made_by() for made_by in MADE_BY]
    path = templates / file
    path.write_text(path.read_text() + "\n")
    assert [made_by() != known for made_by, known in zip(MADE_BY, before, strict=True)] == anew


def test_a_new_template_counts(templates):
    before = [made_by() for made_by in MADE_BY]
    (templates / "bone_maps" / "new.json").write_text(json.dumps({}))
    assert all(made_by() != known for made_by, known in zip(MADE_BY, before, strict=True))


@pytest.mark.parametrize(
    ("version", "anew"), [("SIGNALS_VERSION", [True, True]), ("RANKING_VERSION", [False, True])]
)
def test_a_raised_version_counts(monkeypatch, version, anew):
    before = [made_by() for made_by in MADE_BY]
    monkeypatch.setattr(folder, version, getattr(folder, version) + 1)
    assert [made_by() != known for made_by, known in zip(MADE_BY, before, strict=True)] == anew
