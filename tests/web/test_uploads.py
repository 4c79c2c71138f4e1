# SPDX-License-Identifier: GPL-3.0-or-later
"""Uploads that mean no good: each is refused with a sentence, and nothing but the study is touched."""

import asyncio
import io
import shutil
import stat
import struct
import threading
import time
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import pytest

from w2w.core.library.library import unique_names
from w2w.web.guard import Doors
from w2w.web.receiving import folder_size
from w2w.web.request import INPUT
from w2w.web.uploads import Names, RefusedError, given_name

from ..patience import HANG_S
from .conftest import MOST, made, sent


def zipped(members, method=ZIP_DEFLATED):
    stream = io.BytesIO()
    with ZipFile(stream, "w", method) as archive:
        for member, content in members:
            archive.writestr(member, content)
    return stream.getvalue()


def link(name, to):
    info = ZipInfo(name)
    info.external_attr = (stat.S_IFLNK | 0o777) << 16
    return info, to


def claiming(size):
    """A zip whose only member says that it unpacks to so many bytes."""
    content = bytearray(zipped([("a.bvh", b"x")]))
    at = content.rindex(b"PK\x01\x02") + 24
    content[at : at + 4] = struct.pack("<I", size)
    return bytes(content)


HOSTILE = {
    "out of the folder": (lambda: zipped([("../../evil.bvh", b"x")]), "out of its folder"),
    "absolute": (lambda: zipped([("/tmp/evil.bvh", b"x")]), "out of its folder"),
    "a drive": (lambda: zipped([("C:\\evil.bvh", b"x")]), "out of its folder"),
    "a link": (lambda: zipped([link("a.bvh", "/etc/passwd")]), "is a link"),
    "a link to a folder": (lambda: zipped([link("a", "/tmp"), ("a/b.bvh", b"x")]), "is a link"),
    "a bomb": (lambda: zipped([("a.bvh", bytes(80_000_000))]), "would unpack to 80 MB"),
    "a bomb in parts": (
        lambda: zipped([(f"{n}.bvh", bytes(1_000_000)) for n in range(9)]),
        "would unpack to 9 MB",
    ),
    "4 GB claimed": (lambda: claiming(2**32 - 2), "would unpack to 4295 MB"),
    "more than it claims": (lambda: claiming(0), "no zip that can be read"),
    "2,001 files": (lambda: zipped([(f"{n}.bvh", b"") for n in range(2_001)]), "at most 2000"),
    "no zip": (lambda: b"PK\x03\x04 and then nothing", "no zip that can be read"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_hostile_zip_is_refused_with_a_sentence(client, tmp_path, case):
    make, sentence = HOSTILE[case]
    before = everything(tmp_path)
    study, reply = sent(client, {"clips.zip": make()})
    assert reply.status_code == 400
    assert reply.json()["files"] == {}
    assert sentence in reply.json()["refused"]["clips.zip"]
    client.delete(study)
    assert everything(tmp_path) - {"data/local"} == before


def own_name(name, files):
    return Names(files).own(given_name(name))


def everything(folder):
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*")}


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("../evil.bvh", "must not lead out"),
        ("/etc/evil.bvh", "must not lead out"),
        ("a/../../evil.bvh", "must not lead out"),
        ("a\\evil.bvh", "must not lead out"),
        ("x" * 300 + ".bvh", "too long"),
        ("/".join("abcdefghijk") + ".bvh", "too many folders"),
        ("page.html", "no motion file"),
        ("a.bvh/b", "no motion file"),
    ],
)
def test_a_name_that_is_none_is_refused(name, sentence):
    with pytest.raises(RefusedError, match=sentence):
        own_name(name, {})


def test_names_on_disk_are_harmless_and_name_clips_as_a_run_does():
    assert own_name("walking/Walking (2).fbx", {}) == "walking/Walking (2).fbx"
    assert own_name("<img src=x onerror=alert(1)>.bvh", {}) == "_img src=x onerror=alert(1)_.bvh"
    assert own_name(".w2w/aux/con.bvh", {}) == "_w2w/_aux/_con.bvh"
    assert own_name("a/b;$(rm -rf).bvh", {}) == "a/b__(rm -rf).bvh"
    for name in ("ä ö/X Bot@Kick (1).fbx", "a;b/c'd.bvh"):
        assert unique_names([own_name(name, {})]) == unique_names([name])


def test_files_whose_names_are_one_on_disk_stay_two_and_one_that_comes_again_stays_one():
    assert own_name("?.bvh", {"_.bvh": "*.bvh"}) == "__2.bvh"
    assert own_name("A.bvh", {"a.bvh": "a.bvh"}) == "A_2.bvh"
    assert own_name("a.bvh", {"a.bvh": "a.bvh"}) == "a.bvh"
    assert own_name("ü.bvh", {"_.bvh": "ü.bvh"}) == "_.bvh"


def test_a_page_named_as_a_motion_is_taken_for_what_it_is(client):
    study, reply = sent(client, {"<b>walk.bvh": b"<!doctype html><script>alert(1)</script>"})
    assert reply.json()["files"] == {"_b_walk.bvh": "<b>walk.bvh"}
    until = time.monotonic() + HANG_S
    while not (facts := client.get(study).json()["table"][0]["judged"]):
        assert time.monotonic() < until
    assert "BVH" in facts["problem"]


def test_more_than_there_is_room_for_is_refused(opened):
    client = opened(most=1000)
    study, reply = sent(client, {"a.bvh": bytes(2000)})
    assert reply.status_code == 413
    assert "at once are not taken" in reply.json()["problem"]
    assert sent(client, {"a.bvh": bytes(600)}, study)[1].status_code == 201
    refused = sent(client, {"b.bvh": bytes(600)}, study)[1].json()["refused"]
    assert "no room" in refused["b.bvh"]


def test_too_many_files_at_once_are_refused(client):
    study, reply = sent(client, {f"{n}.bvh": b"" for n in range(201)})
    assert reply.status_code == 400
    assert "Too many files" in reply.json()["problem"]
    assert client.get(study).json()["clips"] == 0


def test_a_library_in_a_zip_keeps_its_folders_and_labels(client):
    labels = b"file,activity\nx/a.bvh,jump\n"
    study, reply = sent(
        client,
        {"z.zip": zipped([("LIB/x/a.bvh", b"1"), ("LIB/labels.csv", labels), ("LIB/.DS_Store", b"")])},
    )
    assert set(reply.json()["files"]) == {"x/a.bvh", "labels.csv"}
    assert set(reply.json()["refused"]) == {".DS_Store"}
    assert [row["activity"] for row in client.get(study).json()["table"]] == ["jump"]


def test_a_connection_that_breaks_leaves_nothing(opened, tmp_path):
    client = opened()
    study = made(client)
    head = b'--x\r\nContent-Disposition: form-data; name="files"; filename="a.bvh"\r\n\r\n'
    messages = [
        {"type": "http.request", "body": head + bytes(100_000), "more_body": True},
        {"type": "http.disconnect"},
    ]

    async def receive():
        return messages.pop(0)

    async def send(_):
        pass

    headers = [(b"host", b"127.0.0.1"), (b"content-type", b"multipart/form-data; boundary=x")]
    scope = {
        "type": "http",
        "method": "POST",
        "path": f"{study}/files",
        "query_string": b"",
        "headers": headers,
    }
    before = everything(tmp_path)
    asyncio.run(client.app(scope | {"scheme": "http", "root_path": "", "http_version": "1.1"}, receive, send))
    assert not messages
    assert everything(tmp_path) == before


def test_files_lie_in_the_study_alone(client, tmp_path):
    study, _ = sent(client, {"a/b.bvh": b"1"})
    folder = tmp_path / "data" / "local" / study.rpartition("/")[2]
    assert everything(folder) == {INPUT, f"{INPUT}/a", f"{INPUT}/a/b.bvh", "request.json"}
    assert (folder / INPUT / "a/b.bvh").read_bytes() == b"1"
    assert Doors("127.0.0.1", (), (), MOST).owner("") == "local"


def test_room_is_measured_while_other_uploads_come_and_go(tmp_path):
    """Each upload has a folder of its own, which another thread removes meanwhile."""
    (tmp_path / "kept.bvh").write_bytes(bytes(7))
    ended = threading.Event()

    def come_and_go():
        while not ended.is_set():
            folder = tmp_path / "arriving"
            folder.joinpath("deeper").mkdir(parents=True)
            shutil.rmtree(folder)

    other = threading.Thread(target=come_and_go)
    other.start()
    try:
        assert {folder_size(tmp_path) for _ in range(2000)} == {7}
    finally:
        ended.set()
        other.join()
