# SPDX-License-Identifier: GPL-3.0-or-later
"""A library of two sources, from its files to the page that says how far its map repeats."""

import csv
import json
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from tests.clip_lists import used_clips
from w2w.core.body.body import N_JOINTS
from w2w.core.motion.motion import Motion
from w2w.headless.app import APP

pytestmark = pytest.mark.usefixtures("one_worker")
OPTIONS = "--patches 8 --no-pictures --no-report --workers 1 --halvings 2 --window 1 --fewest 5".split()
PACES = {"slow": 0.5, "fast": 2.0}
PERFORMERS = 4


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Two sources, each with two activities by four performers."""
    folder, time = tmp_path_factory.mktemp("two sources"), np.arange(90) / 30
    rows = [("file", "activity", "subject", "source")]
    for source in ("film", "lab"):
        for number in range(PERFORMERS):
            axes = np.random.default_rng([len(source), number]).normal(size=(N_JOINTS, 3)) / 5
            for activity, pace in PACES.items():
                angles = np.sin(2 * np.pi * pace * (1 + number / 20) * time)
                turns = Rotation.from_rotvec((angles[:, None, None] * axes).reshape(-1, 3)).as_matrix()
                pelvis = np.stack([time / 5, 0 * time, np.ones_like(time)], axis=1)
                motion = Motion(turns.reshape(-1, N_JOINTS, 3, 3), pelvis, 30.0, activity, "", "clip")
                name = f"{source}_{activity}_{number}.npz"
                motion.save(folder / name)
                rows.append((name, activity, f"{source} {number}", source))
    with (folder / "labels.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows(rows)
    return folder


@pytest.fixture(scope="module")
def studied(one_worker, library, tmp_path_factory):  # noqa: ARG001
    out = tmp_path_factory.mktemp("studied") / "out"
    done = CliRunner().invoke(
        APP,
        [
            "study",
            "library",
            str(library),
            "--labels",
            str(library / "labels.csv"),
            "--out",
            str(out),
            *OPTIONS,
        ],
    )
    assert done.exit_code == 0, done.output
    return out, done.output


def test_the_page_says_how_far_the_map_repeats(studied):
    out, told = studied
    page = (out / "library.md").read_text()
    assert "| film | 8 | 4 | 2 |" in page
    assert "| within each source | 2 |" in page
    assert "No learning curve: fewer than two activities have 20 clips." in page
    assert "One source left out at a time, the 2 activities that several sources show" in page
    assert "| fast | film 4, lab 4 | " in page
    assert "| less film | " in page
    assert not (out / "library_curve.png").exists()
    assert "Maps of disjoint halves of the performers agree at rho" in " ".join(told.split())


def test_the_files_hold_what_the_page_shows(studied):
    out, _ = studied
    with (out / "library.csv").open(newline="") as stream:
        rows = {row["activity"]: row for row in csv.DictReader(stream)}
    assert set(rows) == set(PACES)
    assert rows["slow"]["sources"] == "film, lab"
    assert (rows["slow"]["clips"], rows["slow"]["performers"]) == ("8", "8")
    assert 0 < float(rows["fast"]["f1_best_patch"]) <= 1
    assert float(rows["fast"]["source_chance"]) == 0.5
    content = json.loads((out / "library.json").read_text())
    assert content["curve"] == []
    assert -1 <= content["rho_of_halves"] <= 1
    assert {entry["source"] for entry in used_clips(out)} == {
        "film",
        "lab",
    }
    with (out / "labels.csv").open(newline="") as stream:
        assert len(list(csv.DictReader(stream))) == 16


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ([], "no file in .* has a name that a known library gives its clips"),
        (["--labels", "no_source.csv"], "no_source.csv gives film_fast_0.npz no source"),
        (
            ["--labels", "{library}/labels.csv"],
            r"fewer than two activities have 10 clips \(fast: 8\): lower --",
        ),
    ],
)
def test_what_cannot_be_understood_is_said(library, tmp_path, monkeypatch, options, why):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "no_source.csv").write_text("file,activity\nfilm_fast_0.npz,fast\nfilm_slow_0.npz,slow\n")
    options = [option.format(library=library) for option in options]
    done = CliRunner().invoke(APP, ["study", "library", str(library), "--out", "out", *options])
    assert done.exit_code == 2
    assert re.search(why, " ".join(done.output.split()))


def test_labels_are_of_one_folder(library, tmp_path):
    both = [str(library), str(library)]
    done = CliRunner().invoke(
        APP, ["study", "library", *both, "--labels", "labels.csv", "--out", str(tmp_path / "out")]
    )
    assert done.exit_code == 2
    assert "--labels is of one LIBRARY" in done.output
