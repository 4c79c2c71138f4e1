# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w run` from a folder of made FBX and BVH files to a ranking, without any data but what is made here."""

import csv
import json
from functools import partial

import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.headless.app import APP

from ..clip_lists import skipped_clips, used_clips
from ..made_motions import FILES

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("one_worker", "few_orders")]

ACTIVITIES = ("squatting", "walking", "waving")


@pytest.fixture(scope="module")
def ranked(made_files, made_once):
    out = made_once("ranked", partial(_run, made_files[0])) / "out"
    with (out / "utility.csv").open(newline="") as stream:
        return json.loads((out / "summary.json").read_text()), list(csv.DictReader(stream)), out


def _run(library, folder):
    options = "--patches 24 --window 1 --stride 0.5 --no-pictures --no-report --workers 1".split()
    bone_map = ["--bone-map", str(library / "werkstatt.json")]
    result = CliRunner().invoke(APP, ["run", str(library), "--out", str(folder / "out"), *bone_map, *options])
    assert result.exit_code == 0, result.output


def test_every_file_is_used_with_its_frames(made_files, ranked):
    out = ranked[2]
    assert skipped_clips(out) == {}
    used = {entry["file"]: entry for entry in used_clips(out)}
    assert used.keys() == FILES.keys()
    for file, clip in made_files[1].items():
        assert used[file]["frames"] == len(clip.heads)
        assert used[file]["activity"] == clip.activity
        assert used[file]["duration_s"] == pytest.approx(3.0, abs=0.01)


def test_the_ranking_finds_where_the_activities_show(ranked):
    """Feet stand while the body squats or waves, and only walking lifts them.

    They cannot tell the two apart, which trunk, thighs and arms can.
    """
    summary, rows, _ = ranked
    assert len(rows) == 24
    f1 = np.array([[float(row[name]) for name in ACTIVITIES] for row in rows])
    np.testing.assert_allclose([float(row["mean"]) for row in rows], f1.mean(axis=1), atol=2e-6)
    regions = np.array([row["region"] for row in rows])
    on_feet = np.array([name.endswith(("sole", "toes")) for name in regions])
    assert on_feet.sum() >= 2
    assert (f1[on_feet, 1] > f1[on_feet][:, [0, 2]].max(axis=1)).all()
    assert f1[on_feet].mean(axis=1).max() < 0.85
    best = summary["best_single_patch"]
    assert best["mean_f1"] == pytest.approx(f1.mean(axis=1).max(), abs=2e-6)
    assert best["mean_f1"] > 0.95
    assert not on_feet[best["patch"]]
    tellers = np.array([name.endswith(("thigh back", "forearm volar", "spine")) for name in regions])
    assert f1[tellers].mean(axis=1).min() > 0.95
    assert summary["worn_together"]["reached"]


def test_signals_and_motions_of_every_file_are_written(made_files, ranked):
    out = ranked[2]
    clips = made_files[1]
    for entry in used_clips(out):
        with np.load(out / "signals" / f"{entry['clip']}.npz", allow_pickle=False) as signals:
            # three seconds at 50 Hz, both ends; BVH rounds the frame time, and may end just before
            assert signals["acc"].shape in ((151, 24, 3), (151 - entry["file"].endswith(".bvh"), 24, 3))
            assert np.isfinite(signals["acc"]).all()
        with np.load(out / "motions" / f"{entry['clip']}.npz", allow_pickle=False) as motion:
            assert motion["poses"].shape == (len(clips[entry["file"]].heads), 72)
