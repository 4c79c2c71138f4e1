# SPDX-License-Identifier: GPL-3.0-or-later
"""What a results folder says of the programs that made it."""

from __future__ import annotations

from functools import cache
from importlib import metadata

import numpy as np

import w2w
from w2w.core.findings import summary
from w2w.core.findings.summary import versions


def test_the_versions_are_those_at_work():
    found = versions()
    assert found["w2w"] == w2w.__version__
    assert found["numpy"] == np.__version__


def test_a_library_that_is_missing_is_left_out_and_without_the_tree_pip_is_asked(monkeypatch, tmp_path):
    def version(name):
        if name != "where-to-wear":
            raise metadata.PackageNotFoundError(name)
        return "9.9"

    monkeypatch.setattr("w2w.core.findings.summary.PACKAGE", tmp_path / "lib" / "w2w")
    monkeypatch.setattr(metadata, "version", version)
    monkeypatch.setattr(summary, "_installed", cache(summary._installed.__wrapped__))
    assert versions()["w2w"] == "9.9"
    assert "scipy" not in versions()
