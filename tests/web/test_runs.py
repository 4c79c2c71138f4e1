# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that the web app does: the bytes of the command line's, through crashes, cancelling and upgrades."""

import asyncio
import csv
import html
import io
import json
import os
import shutil
import time
import zipfile

import pytest

from w2w.core.study.results import StudyResults
from w2w.web.request import RESULTS
from w2w.web.study import Study
from w2w.web.work import Reader, Work

from ..clip_lists import skipped_clips
from ..command_line import cli
from ..hostile_c3d import plant, write_hostile
from ..patience import HANG_S
from ..phone_exports import worn_like_clips
from .conftest import FEW, MOST, ended, folder_of, judged, sent


def test_old_studies_are_deleted_and_waiting_ones_go_on(tmp_path):
    work = Work(tmp_path, 1, "", keep_days=1e-9)
    old, waiting = Study.make(tmp_path / "local"), Study.make(tmp_path / "local")
    waiting.change(asked=1.0)
    begun = []
    work._run = lambda study: begun.append(study.id) or asyncio.sleep(0)

    async def a_while():
        work.start()
        await asyncio.sleep(0.05)
        await work.stop()

    asyncio.run(a_while())
    assert begun == [waiting.id]
    assert not old.folder.exists()
    assert waiting.folder.exists()


@pytest.mark.later
@pytest.mark.usefixtures("own_reader")
def test_a_reader_that_dies_is_followed_by_another():
    async def twice():
        reader = Reader()
        try:
            return await reader.ask(os._exit, 3), await reader.ask(os.getpid)
        finally:
            reader.close()

    died, lives = asyncio.run(twice())
    assert died is None
    assert lives != os.getpid()


@pytest.mark.slow
@pytest.mark.usefixtures("own_reader")
def test_a_file_that_crashes_its_reader_costs_neither_the_server_nor_a_run(
    opened, motions, tmp_path, monkeypatch
):
    begun = plant(tmp_path / "planted", monkeypatch)
    (file,) = write_hostile(tmp_path / "hostile", ("crashes",))
    client = opened()
    study, _ = sent(client, motions[1] | {"fast/crashes.c3d": file.read_bytes()})
    rows = {row["file"]: row["judged"] for row in judged(client, study)["table"]}
    assert "the program that reads it crashed" in rows["fast/crashes.c3d"]["problem"]
    assert begun.exists()
    client.post(f"{study}/run", json=FEW)
    assert (now := ended(client, study))["state"] == "finished", now["sentence"]
    assert skipped_clips(folder_of(study, tmp_path) / RESULTS).keys() == {"fast/crashes.c3d"}


@pytest.mark.slow
def test_a_run_is_that_of_the_command_line_and_can_be_chosen_from_again(opened, motions, tmp_path):
    client = opened(most=10 * MOST)
    library, files = motions
    study, _ = sent(client, files)
    assert client.post(f"{study}/run", json=FEW).json()["state"] in ("queued", "running")
    assert client.post(f"{study}/run", json=FEW).status_code == 409
    now = ended(client, study)
    assert now["state"] == "finished", now["sentence"]
    told = [line for line in client.get(f"{study}/events").text.splitlines() if line]
    assert json.loads(told[-1].removeprefix("data: "))["answer"] == now["answer"]

    shutil.copytree(library, tmp_path / "library")
    options = [f"--{name}={value}" for name, value in FEW.items()]
    assert cli("run", tmp_path / "library", "--out", tmp_path / "out", "--no-pictures", *options)[0] == 0
    ours = client.get(f"{study}/files/utility.csv")
    assert ours.content == (tmp_path / "out/utility.csv").read_bytes()
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert now["answer"] == summary["answer"]["sentence"]

    with zipfile.ZipFile(io.BytesIO(client.get(f"{study}/results.zip").content)) as archive:
        assert archive.testzip() is None
        assert {"report.html", "summary.json", "study.blend", "utility.csv"} <= set(archive.namelist())
    report = client.get(f"{study}/files/report.html")
    assert "sha256-" in report.headers["content-security-policy"]
    assert client.get(f"{study}/files/.w2w/state.json").status_code == 404
    assert client.get(f"{study}/files/..%2frequest.json").status_code == 404

    assert cli("place", tmp_path / "out", "--forbid", "leg", "--out", tmp_path / "placed.json")[0] == 0
    placed = client.post(f"{study}/place", json={"forbid": "leg"}).json()
    assert placed == json.loads((tmp_path / "placed.json").read_text())
    region = next(csv.DictReader(ours.text.splitlines()))["region"]
    compared = client.post(f"{study}/place", json={"compare": region}).json()["compared"]
    assert [place["name"] for place in compared] == [region]
    wishes = json.dumps({"forbid": "leg"})
    page = client.get(f"{study}/files/report.html", params={"wishes": wishes})
    assert placed["answer"]["sentence"] in html.unescape(page.text)
    assert "sha256-" in page.headers["content-security-policy"]
    assert client.get(f"{study}/files/report.html", params={"wishes": "{"}).status_code == 400
    needs = client.post(f"{study}/need", json={"place": region}).json()["needs"]
    assert [need["place"] for need in needs] == [region]
    assert client.post(f"{study}/need", json={"place": "nowhere"}).status_code == 400
    worn = worn_like_clips(StudyResults.load(tmp_path / "out"), tmp_path / "worn", 0, 3)
    place = StudyResults.load(tmp_path / "out").patches.names[0]
    parts = [
        ("files", (str(file.relative_to(worn)), file.read_bytes())) for file in sorted(worn.rglob("*.csv"))
    ]
    refused = client.post(f"{study}/pilot", data={"at": "nowhere"}, files=parts)
    assert refused.status_code == 400
    assert "nowhere" in refused.json()["problem"]
    assert client.post(f"{study}/pilot", data={"at": place}, files=parts[:1]).status_code == 400
    said = client.post(f"{study}/pilot", data={"at": place}, files=parts).json()
    assert said["sentence"].startswith(f"With your pilot ({place}, 2 people, ")
    assert said["sentence"] in html.unescape(client.get(f"{study}/files/report.html").text)
    zipped = io.BytesIO()
    with zipfile.ZipFile(zipped, "w") as archive:
        for name, content in (one for _, one in parts):
            archive.writestr(f"worn/{name}", content)
        archive.writestr("worn/notes.txt", b"")
    again = [("files", ("worn.zip", zipped.getvalue()))]
    unzipped = client.post(f"{study}/pilot", data={"at": place}, files=again).json()
    assert unzipped["worn"] == said["worn"]
    assert unzipped["skipped"][-1] == ["notes.txt", "'notes.txt' is no motion file, table or labels.csv"]
    looks = client.post(f"{study}/pilot/signals", files=again).json()
    seen = {look["file"] for look in looks["recordings"]} | {file for file, _ in looks["skipped"][:-1]}
    assert seen == {f"worn/{name}" for _, (name, _) in parts}
    assert all(len(look["signal"]) == 400 and look["seconds"] > 2 for look in looks["recordings"])
    assert len(looks["recordings"]) > 4
    told = "How cheap the sensor may be:", "tell nothing about the sensor"
    assert not any(text in page.text for text in told)
    page = client.get(f"{study}/files/report.html", params={"wishes": wishes, "need": "1"})
    assert any(text in page.text for text in told)
    assert client.post(f"{study}/place", json={"only": "nowhere"}).status_code == 400
    assert client.post(f"{study}/place", json={"costs": "/etc/passwd"}).status_code == 400


@pytest.mark.slow
def test_a_run_that_is_cancelled_or_whose_server_ends_goes_on(opened, motions, tmp_path):
    client = opened()
    study, _ = sent(client, motions[1])
    state = folder_of(study, tmp_path) / RESULTS / ".w2w" / "state.json"
    for end in (lambda: client.post(f"{study}/cancel"), lambda: client.__exit__(None, None, None)):
        state.unlink(missing_ok=True)
        client.post(f"{study}/run", json=FEW)
        until = time.monotonic() + HANG_S
        while not state.exists():
            assert time.monotonic() < until
            time.sleep(0.02)
        end()
        assert not (folder_of(study, tmp_path) / RESULTS / "summary.json").exists()
    assert Study(folder_of(study, tmp_path)).waits
    client = opened()  # the next server takes it up by itself
    assert ended(client, study)["state"] == "finished"


@pytest.mark.later
def test_a_run_that_cannot_be_says_why(client, motions):
    study, _ = sent(client, {"slow/a.npz": motions[1]["slow/slow_0.npz"]})
    client.post(f"{study}/run", json=FEW)
    now = ended(client, study)
    assert now["state"] == "failed"
    assert "activit" in now["sentence"]


def test_each_animation_of_a_file_has_a_row_of_the_table(client, motions):
    channel = {"sampler": 0, "target": {"node": 0, "path": "rotation"}}
    animations = [{"name": name, "channels": [channel], "samplers": []} for name in ("Walk", "Run")]
    content = {"asset": {"version": "2.0"}, "nodes": [{"name": "Hips"}], "animations": animations}
    study, _ = sent(client, {"pack.gltf": json.dumps(content).encode()})
    rows = client.get(study).json()["table"]
    assert [(row["file"], row["activity"]) for row in rows] == [
        ("pack.gltf/Walk", "walk"),
        ("pack.gltf/Run", "run"),
    ]
    rows[0] |= {"activity": "stroll"}
    labels = [{name: row[name] for name in ("file", "activity", "subject")} for row in rows]
    assert client.put(f"{study}/labels", json=labels).status_code == 200
    sent(client, {"slow/slow_0.npz": motions[1]["slow/slow_0.npz"]}, study)
    found = {row["file"]: row["activity"] for row in client.get(study).json()["table"]}
    assert found == {"pack.gltf/Walk": "stroll", "pack.gltf/Run": "run", "slow/slow_0.npz": "slow"}
