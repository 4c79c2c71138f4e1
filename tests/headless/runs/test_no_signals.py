# SPDX-License-Identifier: GPL-3.0-or-later
"""A run that keeps no signals has the same results, and its signals are made again."""

import numpy as np
import pytest
from typer.testing import CliRunner

import w2w
from w2w.core.imu.presets import preset
from w2w.core.imu.recording import ImuRecording
from w2w.headless.app import APP

from ...command_line import cli
from ...sensor_steps import assert_same_to_one_step

OPTIONS = ["--patches", "8", "--workers", "1", "--folds", "2", "--no-pictures", "--window", "1"]

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")


def run(library, out, *options):
    return cli("run", library, "--out", out, *OPTIONS, *options)


@pytest.mark.slow
def test_signals_that_were_not_kept_are_made_again(motions, tmp_path):
    kept, made = tmp_path / "kept", tmp_path / "made"
    assert run(motions, kept)[0] == run(motions, made, "--no-signals")[0] == 0
    files = sorted((kept / "signals").iterdir())
    assert len(files) == 8
    assert not list((made / "signals").iterdir())
    for name in ("utility.csv", "placements.csv", "summary.json"):
        assert (made / name).read_bytes() == (kept / name).read_bytes()
    again = {one.clip: one for one in w2w.stream(made)}
    for file in files:
        stored, one = ImuRecording.load(file), again[file.stem]
        np.testing.assert_array_equal(one.values, stored.values)
        assert (one.sites, one.activity, one.subject) == (stored.sites, stored.activity, stored.subject)
    at = w2w.stream(made, ["left middle finger"])
    for some, one in zip(at, w2w.stream(kept, ["left middle finger"]), strict=True):
        assert_same_to_one_step(some, one, preset("bmi270"))
        assert one.n_sensors == 1
    export = [
        str(made),
        "--for",
        "aeon",
        "--out",
        str(tmp_path / "windows"),
        "--places",
        "left middle finger",
    ]
    assert CliRunner().invoke(APP, ["export", *export]).exit_code == 0

    assert run(motions, kept, "--no-signals")[0] == 0
    assert not list((kept / "signals").iterdir())
    assert run(motions, kept)[0] == 0
    assert len(list((kept / "signals").iterdir())) == 8


@pytest.mark.parametrize(
    ("option", "why"), [(("--garment", "tshirt"), "garments"), (("--classifier", "multi3net"), "multi3net")]
)
def test_what_cannot_do_without_them_is_refused(motions, tmp_path, option, why):
    code, said = run(motions, tmp_path / "out", "--no-signals", *option)
    assert code == 2
    assert f"{why} cannot do without them" in said
