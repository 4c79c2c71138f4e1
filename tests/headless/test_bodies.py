# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies on several bodies: what a person writes is understood, and the maps are compared."""

import json
import shutil

import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.core.body.body import N_JOINTS, PARENTS, Y_UP_TO_Z_UP
from w2w.headless.app import APP
from w2w.headless.options import parse_bodies
from w2w_studies.commands.demo_library import ACTIVITIES, write_demo_library

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")


def test_bodies_are_understood():
    bodies = dict(parse_bodies("neutral, female height=1.55,male weight=95"))
    assert list(bodies) == ["neutral", "female_height_1.55", "male_weight_95"]
    assert bodies["female_height_1.55"].height == pytest.approx(1.55, abs=1e-3)
    assert bodies["male_weight_95"].height > bodies["female_height_1.55"].height


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "at least one body"),
        ("giant", "no body that W2W knows"),
        ("female height=tall", "not understood"),
        ("male shoe=44", "no shape parameter"),
        ("male height=5", "height"),
        ("female, female", "the same"),
        ("a.npz betas=tall", "betas=tall"),
        ("a.npz betas=/nowhere/walk.npz", "an npz that holds 'betas'"),
        ("a.obj betas=1:2", "not there"),
    ],
)
def test_what_is_not_understood_is_said(text, message):
    with pytest.raises(ValueError, match=message):
        parse_bodies(text)


@pytest.mark.slow
def test_betas_from_a_motion_shape_a_model(tmp_path, bundled_body):
    model = {
        "v_template": bundled_body.vertices @ Y_UP_TO_Z_UP,
        "f": bundled_body.faces.astype(np.uint32),
        "J_regressor": np.full((N_JOINTS, len(bundled_body.vertices)), 1 / len(bundled_body.vertices)),
        "weights": bundled_body.weights,
        "kintree_table": np.array(
            [np.array(PARENTS).astype(np.uint32), np.arange(N_JOINTS, dtype=np.uint32)]
        ),
        "shapedirs": 0.1 * (bundled_body.vertices @ Y_UP_TO_Z_UP)[..., None],
    }
    np.savez(tmp_path / "model.npz", **model)
    np.savez(tmp_path / "walk.npz", betas=np.array([[0.5]]), poses=np.zeros((3, 72)))
    file = tmp_path / "model.npz"
    (name, plain), (shaped_name, shaped) = parse_bodies(f"{file}, {file} betas={tmp_path / 'walk.npz'}")
    assert (name, shaped_name) == ("model.npz", "model.npz_betas_walk.npz")
    assert shaped.height == pytest.approx(1.05 * plain.height)


@pytest.mark.slow
def test_a_study_on_two_bodies_says_how_far_they_agree(tmp_path):
    library = tmp_path / "library"
    write_demo_library(library, clips_per_activity=2)
    for activity in ACTIVITIES[2:]:  # two are enough to compare
        shutil.rmtree(library / activity)
    result = CliRunner().invoke(
        APP,
        ["run", str(library), "--out", str(tmp_path / "out"), "--bodies", "female, male", "--patches", "12",
         "--no-pictures", "--no-report", "--workers", "1"],
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    comparison = json.loads((tmp_path / "out/bodies.json").read_text())
    assert set(comparison["bodies"]) == {"female", "male"}
    assert comparison["bodies"]["male"]["height_m"] > comparison["bodies"]["female"]["height_m"]
    pair = comparison["agreement"][0]
    assert pair["interval"][0] <= pair["spearman_mean"] <= pair["interval"][1]
    tables = [(tmp_path / "out" / name / "utility.csv").read_text() for name in ("female", "male")]
    assert tables[0] != tables[1]
    vertices = [[line.split(",")[2] for line in table.splitlines()] for table in tables]
    assert vertices[0] == vertices[1]  # patches stay put


@pytest.mark.slow
def test_a_rigged_smpl_body_is_adopted(shared_data):
    [(name, body)] = parse_bodies(str(shared_data / "smpl_body/fixture_smplbody_rigged.fbx"))
    assert name == "fixture_smplbody_rigged.fbx"
    assert body.height == pytest.approx(1.79, abs=0.01)


def test_a_file_that_is_no_body_is_refused(shared_data):
    with pytest.raises(ValueError, match="expected"):
        parse_bodies(str(shared_data / "mixamo/_broken/static_mesh_box_001.fbx"))
