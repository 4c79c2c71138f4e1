# SPDX-License-Identifier: GPL-3.0-or-later
"""A designer's wishes in words become what the choice may and must take."""

import numpy as np
import pytest

from w2w.core.patches.patches import sample_patches
from w2w.core.selection.constraints import Constraints, read_costs


def test_only_forbid_must_and_costs(patches):
    wishes = Constraints(
        only=("left", "middle"),
        forbid=("head", "hand"),
        must=("left wrist",),
        costs=(("leg", 3.0), ("left foot", 5.0)),
    )
    terms = wishes.terms(patches)
    for place, region in enumerate(patches.regions):
        if region.startswith("right") or region in ("scalp crown", "left ear", "left palm"):
            assert not terms.allowed[place]
        if region in ("left shin", "sternum", "left wrist dorsal"):
            assert terms.allowed[place]
        assert terms.price[place] == {"left heel": 5.0, "left shin": 3.0, "sternum": 1.0}.get(
            region, terms.price[place]
        )
    (group,) = terms.required
    assert len(group)
    assert all(patches.regions[place].startswith("left wrist") for place in group)


def test_no_wishes_allow_everything(patches):
    terms = Constraints().terms(patches)
    assert terms.allowed.all()
    assert terms.required == []
    assert (terms.price == 1).all()


@pytest.mark.parametrize(
    ("wishes", "complaint"),
    [
        ({"only": ("left",), "forbid": ("left",)}, "nothing is left to choose from: only left, without left"),
        ({"must": ("head",), "forbid": ("head",)}, "'head' must be chosen, but no patch there is allowed"),
        ({"forbid": ("tail",)}, "no patch is called 'tail'"),
        ({"must": ("left wrist", "left")}, None),
    ],
)
def test_wishes_that_contradict_each_other_are_refused(patches, wishes, complaint):
    if complaint is None:
        assert len(Constraints(**wishes).terms(patches).required) == 2
        return
    with pytest.raises(ValueError, match=complaint):
        Constraints(**wishes).terms(patches)


def test_a_part_that_must_be_chosen_may_be_forbidden_in_places(patches):
    terms = Constraints(must=("left arm",), forbid=("left wrist",)).terms(patches)
    (anywhere,) = Constraints(must=("left arm",)).terms(patches).required
    (required,) = terms.required
    assert terms.allowed[required].all()
    assert 0 < len(required) < len(anywhere)


def test_where_no_place_lies_nothing_can_be_forbidden_or_required(bundled_body):
    few = sample_patches(bundled_body, 12, seed=0)
    assert not any(region.startswith("left wrist") for region in few.regions)
    assert Constraints(forbid=("left wrist",)).terms(few).allowed.all()
    with pytest.raises(
        ValueError, match="'left wrist' must be chosen, but none of the 12 patches lies there"
    ):
        Constraints(must=("left wrist",)).terms(few)
    with pytest.raises(ValueError, match="only left wrist, where none of the 12 patches lies: use more"):
        Constraints(only=("left wrist",)).terms(few)


def test_costs_are_read_from_a_table(tmp_path, patches):
    table = tmp_path / "costs.csv"
    table.write_text("region,cost\nleft wrist,0.5\nhead,4\n", encoding="utf-8")
    assert read_costs(table) == (("left wrist", 0.5), ("head", 4.0))
    cost = Constraints(costs=read_costs(table)).terms(patches).price
    assert set(np.unique(cost)) == {0.5, 1.0, 4.0}


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (
            "place,price\nhead,4\n",
            "needs the columns 'region' and 'cost' in its first line, and has: place, p",
        ),
        ("region,cost\nhead,dear\n", "line 2: 'dear' is no number"),
        ("region,cost\nhead\n", "line 2: '' is no number"),
        ("", "and has: nothing"),
    ],
)
def test_tables_that_cannot_be_understood_say_where(tmp_path, text, complaint):
    table = tmp_path / "costs.csv"
    table.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=complaint):
        read_costs(table)


@pytest.mark.parametrize("cost", [0.0, -1.0, float("nan"), float("inf")])
def test_costs_must_be_positive(cost):
    with pytest.raises(ValueError, match="the cost of 'head' must be a positive number"):
        Constraints(costs=(("head", cost),))
