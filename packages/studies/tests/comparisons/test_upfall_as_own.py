# SPDX-License-Identifier: GPL-3.0-or-later
"""UP-Fall without code: a folder of recordings and their labels, against a run of the libraries' clips."""

import csv
import json
import tarfile

import numpy as np
import pytest

from tests.command_line import cli
from w2w.core.body.body import Body
from w2w.core.imu.formats import write_recording
from w2w.core.library.library import read_library
from w2w_studies.comparisons.unpaired import load_motions
from w2w_studies.validation.upfall import UPFALL

CAPTURED = UPFALL.analyses[1]


def table(path, rows):
    with path.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream).writerows(rows)
    return path


def plain_recordings(data, folder):
    """UP-Fall as anybody's folder: a csv a sensor, clip by clip, and `labels.csv`."""
    with tarfile.open(data / "imu" / "up_fall" / "up_fall.tar.xz") as archive:
        archive.extractall(folder / "download", filter="data")
    rows = [["file", "activity", "subject"]]
    for one in UPFALL.read(folder / "download"):
        clip = folder / "recordings" / one.clip
        clip.mkdir(parents=True)
        rows.append([one.clip, one.activity, one.subject])
        for sensor, site in enumerate(one.sites):
            if not np.isnan(one.acc[:, sensor]).all():
                write_recording(clip / f"{site}.csv", one.labelled(one.sites, "", "", ""), sensor=sensor)
    return folder / "recordings", table(folder / "recorded.csv", rows)


def plain_library(data, folder):
    """The clips that the protocol's rules find, in one folder under their labels."""
    libraries = []
    for name in ("hdm05", "bandai_namco"):
        libraries.append(folder / name)
        with tarfile.open(data / "library" / f"{name}.tar.xz") as archive:
            archive.extractall(libraries[-1], filter="data")
    clips, rows = folder / "clips", [["file", "activity", "subject"]]
    clips.mkdir()
    for number, library in enumerate([*libraries, data / "mixamo", data / "bvh"]):
        paths = {clip.name: clip.path for clip in read_library(library, own_labels=False).clips}
        for motion, source, name in load_motions(UPFALL, [library], Body.bundled())[0]:
            if source in CAPTURED.sources and motion.activity in CAPTURED.activities:
                file = f"{number} {name}{paths[name].suffix}"
                (clips / file).symlink_to(paths[name])
                rows.append([file, motion.activity, motion.subject])
    return clips, table(folder / "labels.csv", rows)


@pytest.mark.slow
def test_a_folder_of_recordings_gives_what_the_page_says_of_the_data_set(shared_data, tmp_path):
    """docs/truth.md, without the Kinect: rho .90, mean rho .86, regret .024, at random .067, level .11."""
    pytest.importorskip("bpy")
    clips, labels = plain_library(shared_data, tmp_path)
    run = ["--labels", labels, "--by-subject", "--rate", "18", "--band", "8", "--workers", "2"]
    code, output = cli("run", clips, "--out", tmp_path / "run", *run, "--no-pictures", "--no-report")
    assert code == 0, output
    recordings, recorded = plain_recordings(shared_data, tmp_path)
    sites = table(
        tmp_path / "sites.csv", [["place", "site"], *(map(str, pair) for pair in UPFALL.sites.items())]
    )
    given = [tmp_path / "run", recordings, "--labels", recorded, "--sites", sites]
    code, output = cli("validate", "own", *given, "--out", tmp_path / "out")
    assert code == 0, output
    found = json.loads((tmp_path / "out" / "validation_all_activities.json").read_text())
    assert found["mean_f1"]["spearman"] == pytest.approx(0.9)
    assert found["regret"]["lost"] == pytest.approx(0.024, abs=0.0005)
    assert found["regret"]["at_random"] == pytest.approx(0.067, abs=0.0005)
    assert found["rho_mean"] == pytest.approx(0.86, abs=0.02)  # sensors' errors are drawn anew
    assert found["simulated_above_real"]["value"] == pytest.approx(0.11, abs=0.02)
