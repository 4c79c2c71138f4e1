# SPDX-License-Identifier: GPL-3.0-or-later
"""All that `import w2w` offers is documented: the parameters of its signature and an example that runs."""

import doctest
import inspect
from operator import attrgetter
from pathlib import Path

import griffe
import numpy as np
import pytest

import w2w

from .rings import by_day

NAMES = sorted(set(w2w.__all__) - {"__version__"})


SECTIONS = ["text", "parameters", "attributes", "returns", "yields", "raises", "warns", "examples"]
"""In numpydoc's order."""


@pytest.mark.parametrize("name", NAMES)
def test_the_docstring_is_numpydoc_and_says_all_of_the_signature(name):
    thing = getattr(w2w, name)
    sections = griffe.parse_numpy(griffe.Docstring(inspect.getdoc(thing)))
    listed = [
        part.strip(" *")
        for section in sections
        if section.kind.value in ("parameters", "attributes")
        for one in section.value
        for part in one.name.split(",")
    ]
    signature, kinds = inspect.signature(thing), [section.kind.value for section in sections]
    assert listed == list(signature.parameters)
    assert kinds == sorted(kinds, key=SECTIONS.index)
    assert "examples" in kinds
    gives = inspect.isfunction(thing) and signature.return_annotation not in (None, "None")
    assert gives == bool({"returns", "yields"} & {*kinds}), "a function says what it returns"


EXAMPLES = [*NAMES, "Ranking.needs", "Ranking.report"]
LONG = {"rank", "PatchSet", "Ranking.needs", "synthesize"}


@pytest.mark.later
@pytest.mark.parametrize(
    "name", by_day({*EXAMPLES} - {"rank", "PatchSet", "Ranking.needs", "synthesize"}, EXAMPLES)
)
def test_the_example_runs(name, door, monkeypatch):
    monkeypatch.chdir(door)
    thing = attrgetter(name)(w2w)
    names = {"w2w": w2w, "np": np, "Path": Path, name: thing}
    (example,) = doctest.DocTestFinder(recurse=False).find(thing, name, globs=names)
    assert example.examples
    assert doctest.DocTestRunner().run(example).failed == 0
