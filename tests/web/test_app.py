# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies from files to the answer, by the interface that the page uses, too."""

import asyncio
import io
import json
import shutil
import zipfile
from errno import ENOSPC

import pytest
from starlette.datastructures import UploadFile

from w2w.core.library.library import read_library
from w2w.core.study.clip_files import CHANGING
from w2w.web import receiving
from w2w.web.request import EVENTS, INPUT
from w2w.web.study import PARAMETERS, Study
from w2w.web.uploads import RefusedError
from w2w.web.work import Work

from .conftest import MOST, PACES, folder_of, judged, made, sent


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
    assert made_here["title"] == "Five gestures at a desk"
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
