# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies from files to the answer, by the interface that the page uses, too."""

import asyncio
import csv
import html
import io
import json
import os
import shutil
import time
import zipfile
from errno import ENOSPC

import pytest
from starlette.datastructures import UploadFile

from w2w.core.library.library import read_library
from w2w.core.study.clip_files import CHANGING
from w2w.core.study.results import StudyResults
from w2w.web import receiving
from w2w.web.request import EVENTS, INPUT, RESULTS
from w2w.web.study import PARAMETERS, Study
from w2w.web.uploads import RefusedError
from w2w.web.work import Reader, Work

from ..clip_lists import skipped_clips
from ..command_line import cli
from ..headless.conftest import write_motions
from ..hostile_c3d import plant, write_hostile
from ..patience import HANG_S
from ..phone_exports import worn_like_clips
from .conftest import MOST, made, sent

PACES = {"slow": 0.5, "fast": 2.0}
FEW = {"patches": 24, "seed": 3}


@pytest.fixture(scope="module")
def motions(made_once):
    """Eight npz motions of two activities, by their paths in the library."""
    folder = made_once("web motions", lambda folder: write_motions(folder, PACES, 4))
    return folder, {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*.npz")}


def ended(client, study):
    until = time.monotonic() + HANG_S
    while (now := client.get(study).json())["state"] in ("queued", "running"):
        assert time.monotonic() < until
        time.sleep(0.05)
    return now


def folder_of(study, tmp_path):
    return tmp_path / "data" / "local" / study.rpartition("/")[2]


def judged(client, study):
    """What is shown of a study once all of its files are judged."""
    until = time.monotonic() + HANG_S
    now = client.get(study).json()
    while any(row["judged"] is None for row in now["table"]):
        assert time.monotonic() < until
        now = client.get(study).json()
    return now


def test_files_are_labelled_by_their_folders_and_judged(client, motions):
    study, reply = sent(client, motions[1])
    assert reply.status_code == 201
    now = judged(client, study)
    assert now["state"] == "draft"
    assert {(row["name"].split("/")[0], row["activity"]) for row in now["table"]} == {(a, a) for a in PACES}
    assert {row["judged"]["duration_s"] for row in now["table"]} == {4.9667}


def test_labels_of_the_table_are_those_of_the_run(client, motions, tmp_path):
    study, _ = sent(client, motions[1])
    rows = [
        {"file": row["file"], "activity": "" if "_3" in row["file"] else "walk, slow", "subject": "Anna"}
        for row in client.get(study).json()["table"]
    ]
    assert client.put(f"{study}/labels", json=rows).status_code == 200
    folder = folder_of(study, tmp_path)
    library = read_library(folder / INPUT, folder / "labels.csv")
    assert {(clip.activity, clip.subject) for clip in library.clips} == {("walk, slow", "Anna")}
    assert len(library.clips) == 6
    assert [row.get("activity") for row in client.get(study).json()["table"]].count("walk, slow") == 6


def test_rates_of_uploaded_labels_are_used_and_kept(client, motions, tmp_path):
    file, *_ = motions[1]
    study, _ = sent(client, {file: motions[1][file]})
    rate = judged(client, study)["table"][0]["judged"]["frame_rate"]
    labels = f"file,activity,rate\n{file},walk,{rate / 2}\n".encode()
    sent(client, {"labels.csv": labels}, study)
    assert judged(client, study)["table"][0]["judged"]["frame_rate"] == rate / 2
    row = {"file": file, "activity": "stroll", "subject": ""}
    assert client.put(f"{study}/labels", json=[row]).status_code == 200
    folder = folder_of(study, tmp_path)
    clip, *_ = read_library(folder / INPUT, folder / "labels.csv").clips
    assert (clip.activity, clip.rate) == ("stroll", rate / 2)


def test_clips_that_come_later_have_their_own_labels_beside_edited_ones(client, motions):
    files = dict(motions[1])
    late = files.pop("slow/slow_0.npz")
    study, _ = sent(client, files)
    rows = client.get(study).json()["table"]
    client.put(f"{study}/labels", json=[row | {"activity": row["activity"].upper()} for row in rows])
    sent(client, {"slow/slow_0.npz": late, "new/new_1.npz": late}, study)
    found = {row["file"]: row["activity"] for row in client.get(study).json()["table"]}
    assert found.pop("new/new_1.npz") == "new"
    assert {label.lower() for label in found.values()} == set(PACES)
    assert len(set(found.values())) == 2


def test_what_is_wrong_with_all_is_said_without_the_server_s_paths(client, tmp_path):
    study, _ = sent(client, {"labels.csv": b"file,activity"})
    reply = client.post(f"{study}/run", json={}).json()
    assert reply["problem"].startswith("the study holds no motion files")
    assert str(tmp_path) not in client.get(study).text


@pytest.mark.parametrize(
    "rows", [{}, [1], [{"file": "x.bvh"}], [{"file": "a.npz", "activity": 3}], "x", [{"file": "../a"}]]
)
def test_labels_that_are_none_are_refused(client, motions, rows):
    study, _ = sent(client, {"a.npz": motions[1]["slow/slow_0.npz"]})
    assert client.put(f"{study}/labels", json=rows).status_code == 400


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ({"patches": 10**9}, "patches must be"),
        ({"patches": "24"}, "patches cannot be"),
        ({"target": True}, "target cannot be"),
        ({"sensor": "/etc/passwd"}, "sensor is one of"),
        ({"pose_up": "w"}, "up must be one of"),
        ({"costs": "/etc/passwd"}, "no parameter 'costs'"),
        ({"out": "/tmp"}, "no parameter 'out'"),
        ({"title": "a\nb"}, "title cannot be"),
        ([], "an object"),
    ],
)
def test_a_wrong_parameter_is_refused(client, motions, asked, sentence):
    study, _ = sent(client, motions[1])
    reply = client.post(f"{study}/run", json=asked)
    assert reply.status_code == 400
    assert sentence in reply.json()["problem"]
    assert client.get(study).json()["state"] == "draft"


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ({"only": "wirst"}, "did you mean wrist?"),
        ({"forbid": "head, left anckle"}, "did you mean left ankle?"),
        ({"must": "wach"}, "did you mean watch?"),
        ({"background": "standing"}, "there are fast, slow"),
    ],
)
def test_a_misspelt_wish_is_refused_with_what_there_is(client, motions, asked, sentence):
    study, _ = sent(client, motions[1])
    reply = client.post(f"{study}/run", json=asked)
    assert reply.status_code == 400
    assert sentence in reply.json()["problem"]
    if "background" not in asked:
        assert sentence in client.put(f"{study}/parameters", json=asked).json()["problem"]


def test_wishes_are_kept_as_they_are_typed_and_taken_back(client, motions):
    study, _ = sent(client, motions[1])
    assert client.put(f"{study}/parameters", json={"only": "wrist", "title": "歩行"}).status_code == 200
    assert client.get(study).json()["parameters"] == {"only": "wrist", "title": "歩行"}
    client.put(f"{study}/parameters", json={"only": "", "title": "歩行"})
    assert client.get(study).json()["parameters"] == {"title": "歩行"}


def test_words_that_look_like_options_stay_words(tmp_path, client):
    study = Study.of(tmp_path / "data" / "local", made(client).rpartition("/")[2])
    study.change(parameters={"title": "--out=/tmp/x", "by_subject": True, "max_places": 2})
    words = study.command(1, "")
    assert "--title=--out=/tmp/x" in words
    assert "--by-subject" in words
    assert "--max=2" in words


def test_without_results_there_is_nothing_to_choose_or_to_fetch(client):
    study = made(client)
    assert client.post(f"{study}/place", json={}).status_code == 409
    assert client.get(f"{study}/results.zip").status_code == 409
    assert client.post(f"{study}/run", json={}).status_code == 400
    assert client.get(f"{study}/files/report.html").status_code == 404


@pytest.mark.later
def test_the_demo_is_a_study_like_others(client, tmp_path):
    made_here = client.post("/api/studies", json={"demo": True}).json()
    rows = client.get(f"/api/studies/{made_here['id']}").json()["table"]
    assert len(rows) == made_here["clips"] == 40
    assert len({row["activity"] for row in rows}) == 5
    client.delete(f"/api/studies/{made_here['id']}")
    assert client.get("/api/studies").json() == []
    assert not any((tmp_path / "data" / "local").iterdir())


@pytest.mark.parametrize("to", ["/api/studies", "{study}/files"])
def test_an_upload_whose_connection_breaks_leaves_nothing(client, tmp_path, to):
    study = made(client)
    before = sorted(tmp_path.rglob("*"))
    form = (
        b'--X\r\nContent-Disposition: form-data; name="files"; filename="walk/a.bvh"\r\n\r\n' + b"M" * 90_000
    )
    messages = [{"type": "http.request", "body": form, "more_body": True}, {"type": "http.disconnect"}]
    headers = {
        "host": "127.0.0.1",
        "content-type": "multipart/form-data; boundary=X",
        "content-length": "190000",
    }
    scope = {
        "type": "http", "method": "POST", "path": to.format(study=study), "query_string": b"",
        "headers": [(name.encode(), value.encode()) for name, value in headers.items()],
    }  # fmt: skip
    answers = []

    async def receive():
        return messages.pop(0)

    async def send(message):
        answers.append(message)

    client.portal.call(client.app, scope, receive, send)
    assert answers[0]["status"] == 400
    assert sorted(tmp_path.rglob("*")) == before


def test_the_page_of_a_finished_study_has_its_sentence_and_picture_as_a_preview(client, tmp_path):
    address = made(client)
    page = address.removeprefix("/api")
    assert "og:" not in client.get("/").text + client.get(page).text
    results = Study.of(tmp_path / "data/local", address.rpartition("/")[2]).results
    results.mkdir()
    (results / "report.html").touch()
    (results / "summary.json").write_text(json.dumps({"answer": {"sentence": '"><script>A watch: F1 .91.'}}))
    shown = client.get(page).text
    assert '<meta property="og:description" content="&quot;&gt;&lt;script&gt;A watch: F1 .91.">' in shown
    picture = f"http://127.0.0.1:8000{address}/files/heatmaps/mean.png"
    assert f'<meta property="og:image" content="{picture}">' in shown
    assert "og:" not in client.get(f"/studies/{'0' * 32}").text


def answered(study):
    """The study with results of a run that has ended."""
    study.results.mkdir()
    (study.results / "report.html").touch()
    (study.results / "summary.json").write_text(json.dumps({"answer": {"sentence": "A watch: F1 .91."}}))
    study.ask(study.checked({}))
    (study.folder / EVENTS).write_text('{"event": "finished", "exit_code": 0}\n')


@pytest.mark.parametrize("old", [True, False])
def test_an_answer_of_what_was_there_before_is_marked(client, motions, tmp_path, old):
    address, _ = sent(client, {"slow/a.npz": motions[1]["slow/slow_0.npz"], "fast/b.npz": b"1"})
    study = Study(folder_of(address, tmp_path))
    answered(study)
    if old:  # an earlier version did not write down what its answers are of
        request = json.loads((study.folder / "request.json").read_text())
        (study.folder / "request.json").write_text(
            json.dumps({name: request[name] for name in ("made", "asked", "parameters", "files", "judged")})
        )
    assert client.get(address).json()["stale"] == ""
    rows = client.get(address).json()["table"]
    client.put(f"{address}/labels", json=[row | {"activity": row["activity"] * 2} for row in rows])
    assert client.get(address).json()["stale"].startswith("Since this answer their labels changed")
    sent(client, {"third/c.npz": motions[1]["slow/slow_0.npz"]}, address)
    client.put(f"{address}/parameters", json={"forbid": "head"})
    said = "Since this answer the clips and their labels and the wishes changed: run again for a new one."
    assert client.get(address).json()["stale"] == said
    study.ask(study.checked({}))
    client.post(f"{address}/cancel")
    assert client.get(address).json()["stale"].startswith("Since this answer the clips")


def test_an_answer_beside_a_run_that_was_stopped_is_marked(client, motions, tmp_path):
    address, _ = sent(client, {"slow/a.npz": motions[1]["slow/slow_0.npz"]})
    study = Study(folder_of(address, tmp_path))
    answered(study)
    (study.results / ".w2w").mkdir()
    (study.results / CHANGING).write_text("run")
    assert client.get(address).json()["stale"].startswith("A new run was stopped")


def test_results_as_a_zip_follow_no_link(client, motions, tmp_path):
    address, _ = sent(client, {"slow/a.npz": motions[1]["slow/slow_0.npz"]})
    study = Study(folder_of(address, tmp_path))
    answered(study)
    secret = tmp_path / "secret"
    secret.mkdir()
    (secret / "key").write_text("x")
    (study.results / "key.csv").symlink_to(secret / "key")
    (study.results / "folder").symlink_to(secret)
    with zipfile.ZipFile(io.BytesIO(client.get(f"{address}/results.zip").content)) as archive:
        assert set(archive.namelist()) == {"report.html", "summary.json"}


@pytest.mark.parametrize("name", ["a.bvh", "clips.zip"])
def test_a_full_disk_is_said_in_words(client, monkeypatch, name):
    def full(*_):
        raise OSError(ENOSPC, "No space left on device")

    study = made(client)
    monkeypatch.setattr(receiving, "store", full)
    reply = sent(client, {name: b"1"}, study)[1]
    assert reply.status_code == 507
    assert "disk is full" in reply.json()["problem"]
    assert client.get(study).json()["table"] == []


def test_an_upload_waits_for_no_file_that_is_being_looked_at(client, motions):
    study = made(client)
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as archive:
        archive.writestr("slow/a.npz", motions[1]["slow/slow_0.npz"])

    async def busy():
        await work.readers.small._one.acquire()
        await work.readers.large._one.acquire()

    work = client.app.state.work
    client.portal.call(busy)
    _, reply = sent(client, {"clips.zip": content.getvalue()}, study)
    assert reply.json()["files"] == {"slow/a.npz": "slow/a.npz"}
    assert client.get(study).json()["table"][0]["judged"] is None


def test_an_upload_that_ends_after_a_run_was_asked_for_is_refused(client, motions, tmp_path):
    address, _ = sent(client, {"slow/a.npz": motions[1]["slow/slow_0.npz"]})
    study = Study(folder_of(address, tmp_path))
    receiver = receiving.Receiver(Work(tmp_path / "data", 1, "", 1.0), MOST)
    study.change(asked=1.0)
    upload = UploadFile(io.BytesIO(b"1"), filename="b.npz", size=1)
    with pytest.raises(RefusedError, match="a run of the study was asked for"):
        asyncio.run(receiver._take([("files", upload)], study))
    assert not (study.folder / INPUT / "b.npz").exists()


def test_what_was_shared_is_seen_without_a_token_until_it_is_taken_back(opened, motions, tmp_path):
    client = opened(["first-token-1"])
    client.headers = {"authorization": "Bearer first-token-1"}
    address = made(client)
    (folder,) = (tmp_path / "data").glob("*/*")
    study = Study(folder)
    sent(client, {"slow/a.npz": motions[1]["slow/slow_0.npz"]}, address)
    answered(study)
    study.change(parameters={"title": 'Nod "well"'})
    (study.results / "report.html").write_text(f"<html><head></head><body>{study.id}</body></html>")
    (study.results / "heatmaps").mkdir()
    (study.results / "heatmaps/mean.png").write_bytes(b"picture")
    link = client.post(f"{address}/share", json={}).json()["link"]
    assert client.get(address).json()["link"] == link
    client.headers = {}
    seen = client.get(link)
    assert seen.status_code == 200
    assert '<meta property="og:description" content="A watch: F1 .91.">' in seen.text
    assert '<meta property="og:title" content="Nod &quot;well&quot;">' in seen.text
    assert client.get(f"{link}/picture.png").content == b"picture"
    for other in (address, f"{address}/files/summary.json", f"{link}/../..", f"{link}x", f"{link[:-3]}"):
        assert client.get(other).status_code in (401, 404)
    client.headers = {"authorization": "Bearer first-token-1"}
    client.delete(f"{address}/share")
    assert client.get(link).status_code == 404
    assert client.post(f"{address}/share", json={}).json()["link"] != link


@pytest.mark.parametrize("link", ["", ".", "0" * 32, "0" * 32 + ".", "*.", "..%2f..%2fx.y"])
def test_a_link_that_was_not_given_leads_nowhere(client, link):
    made(client)
    assert client.get(f"/shared/{link}").status_code == 404


def test_clips_that_are_removed_are_gone_from_list_disk_and_labels(client, motions, tmp_path):
    address, _ = sent(client, motions[1])
    study = Study(folder_of(address, tmp_path))
    rows = judged(client, address)["table"]
    client.put(f"{address}/labels", json=[row | {"activity": "typed"} for row in rows])
    gone = [row["file"] for row in rows if row["activity"] == "slow"]
    assert client.post(f"{address}/remove", json=gone).status_code == 200
    left = client.get(address).json()["table"]
    assert {row["name"] for row in left} == {row["name"] for row in rows} - {*gone}
    assert {row["activity"] for row in left} == {"typed"}
    assert not any((study.folder / INPUT / name).exists() for name in gone)
    for wrong in ({}, [1], "x"):
        assert client.post(f"{address}/remove", json=wrong).status_code == 400
    assert client.post(f"{address}/remove", json=["../request.json"]).status_code == 200
    assert (study.folder / "request.json").exists()


def test_a_clip_shows_as_a_small_figure_and_copies_are_named(client, motions):
    content = motions[1]["slow/slow_0.npz"]
    address, _ = sent(client, {"slow/a.npz": content, "slow/b.npz": content, "bad.bvh": b"1"})
    rows = {row["name"]: row for row in judged(client, address)["table"]}
    assert rows["slow/b.npz"]["copy_of"] == "slow/a.npz"
    assert "copy_of" not in rows["slow/a.npz"]
    frames = client.get(f"{address}/figure", params={"file": "slow/a.npz"}).json()
    assert {len(frame) for frame in frames} == {22 * 3}
    heights = [max(frame[2::3]) - min(frame[2::3]) for frame in frames]
    assert all(100 < height < 220 for height in heights)
    assert len({tuple(frame) for frame in frames}) > 3
    assert client.get(f"{address}/figure", params={"file": "bad.bvh"}).status_code == 404
    assert client.get(f"{address}/figure", params={"file": "../../request"}).status_code == 404


def test_a_clip_that_a_version_without_pictures_judged_gets_its_figure(client, motions, tmp_path):
    address, _ = sent(client, {"slow/a.npz": motions[1]["slow/slow_0.npz"]})
    judged(client, address)
    (folder,) = tmp_path.glob("**/figures")
    shutil.rmtree(folder)
    assert client.get(f"{address}/figure", params={"file": "slow/a.npz"}).json()
    assert [*folder.iterdir()]


def test_openapi_describes_every_address(client):
    page = client.get("/api").json()
    described, schemas = page["paths"], page["components"]["schemas"]
    assert schemas["Parameters"]["properties"].keys() == PARAMETERS.keys()
    assert schemas["Wishes"]["properties"]["max_places"] == {"type": "integer"}
    assert '"#/components/schemas/Wishes"' in json.dumps(described)
    served = {
        (route.path.replace(":path", ""), method.lower())
        for route in client.app.routes
        for method in route.methods - {"HEAD"}
        if route.path.startswith("/api/")
    }
    assert {(path, method) for path, ways in described.items() for method in ways} == served


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
    again = [("files", ("worn.zip", zipped.getvalue()))]
    assert client.post(f"{study}/pilot", data={"at": place}, files=again).json()["worn"] == said["worn"]
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
