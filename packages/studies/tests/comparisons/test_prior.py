# SPDX-License-Identifier: GPL-3.0-or-later
"""What is generally good, by finished runs."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from w2w.core.patches.body_parts import ALL
from w2w_studies.comparisons import prior
from w2w_studies.comparisons.prior import finished_runs, general, mean_of, of_library


def study(regions: list[str], f1: list[float]) -> SimpleNamespace:
    utility = SimpleNamespace(mean=np.array(f1), activities=("hop", "jog"))
    clips = [SimpleNamespace(activity=name) for name in ("hop", "jog", "jog", "sit")]
    return SimpleNamespace(utility=utility, patches=SimpleNamespace(regions=regions), clips=clips)


def test_a_library_tells_regions_by_their_patches_of_both_sides() -> None:
    of_all = of_library(study(["left wrist", "right wrist", "sternum", "left hip"], [0.5, 0.7, 0.9, 0.7]))
    assert of_all == pytest.approx({"wrist": -0.1, "sternum": 0.2, "hip": 0.0})


def test_a_region_counts_by_those_that_have_it() -> None:
    assert mean_of([{"hip": 0.2, "nose": 0.4}, {"hip": 0.4}]) == pytest.approx({"hip": 0.3, "nose": 0.4})


def test_families_count_alike_whatever_their_libraries(tmp_path, monkeypatch) -> None:
    of_family = {
        "lab": {"one": study(["hip", "nose"], [0.9, 0.5]), "two": study(["hip", "nose"], [0.7, 0.7])},
        "game": {"three": study(["hip", "nose"], [0.2, 0.4])},
    }
    monkeypatch.setattr(prior, "finished_runs", lambda family: of_family[family.name])
    found = general([tmp_path / "lab", tmp_path / "game"])
    assert found["regions"] == {"hip": 0.0, "nose": 0.0}  # .1 and -.1
    assert found["families"]["lab"]["one"]["clips"] == 3  # a clip that sits is not ranked
    assert found["command"] == "w2w study prior lab game"


def test_a_family_without_a_finished_run_is_refused(tmp_path) -> None:
    with pytest.raises(ValueError, match="holds no results folder"):
        finished_runs(tmp_path)


def test_the_prior_of_the_studies_is_of_regions_of_a_body_and_says_where_it_is_from() -> None:
    brought = json.loads(Path(prior.__file__).with_suffix(".json").read_text(encoding="utf-8"))
    assert set(brought["regions"]) == set(ALL)
    assert all(library["clips"] for family in brought["families"].values() for library in family.values())
    assert {"command", "version", "date"} <= brought.keys()
