# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w rank-recordings`: from a folder of files to an answer, a report and tables."""

import json

import numpy as np
import pytest

from w2w.core.imu.formats import write_recording
from w2w.core.imu.recording import ImuRecording

from ...command_line import cli

pytestmark = pytest.mark.usefixtures("few_orders", "made_once_here")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two activities, four clips each by two people; the wrist tells them apart, the forehead does not."""
    made = tmp_path_factory.mktemp("recordings")
    rows = ["file,activity,subject"]
    for number in range(8):
        activity, pace = (("walking", 1.0), ("running", 2.5))[number % 2]
        noise = np.random.default_rng(number).normal(size=(2, 250, 1, 6))
        swing = 4 * np.sin(2 * np.pi * pace * np.arange(250) / 25)[:, None, None]
        for place, values in (("left wrist", noise[0] + swing), ("forehead", noise[1])):
            path = made / f"clip {number}" / f"{place}.csv"
            path.parent.mkdir(exist_ok=True)
            write_recording(path, ImuRecording(values[..., :3], values[..., 3:], 25.0))
        rows.append(f"clip {number},{activity},person {number // 4}")
    (made / "mine.csv").write_text("\n".join(rows))
    return made


@pytest.mark.later
def test_the_answer_is_said_and_written(folder, tmp_path):
    out = tmp_path / "out"
    code, output = cli(
        "rank-recordings", folder, "--labels", folder / "mine.csv", "--out", out, "--by-subject"
    )
    assert code == 0, output
    assert output.startswith("Wear a sensor at left wrist.")
    assert "Forehead may cost" in output.replace("\n", " ")
    assert {"f1.csv", "report.html", "summary.json"} <= {path.name for path in out.iterdir()}
    content = json.loads((out / "summary.json").read_text())
    assert content["answer"]["name"] == "left wrist"
    assert content["protocol"] == "leave one of 2 subjects out"
    assert "docs/truth.md" not in output
    asked = ("rank-recordings", folder, "--labels", folder / "mine.csv", "--by-subject", "--json")
    assert json.loads(cli(*asked)[1]) == content


def test_some_places_alone(folder):
    code, output = cli(
        "rank-recordings", folder, "--labels", folder / "mine.csv", "--places", "forehead,belt"
    )
    assert code == 2
    assert "no sensor was worn at 'belt'; there are" in output


def test_a_folder_without_labels_is_refused(folder):
    code, output = cli("rank-recordings", folder)
    assert code == 2
    assert "only one clip" in output.replace("\n", " ")
