# SPDX-License-Identifier: GPL-3.0-or-later
"""Which clips a study has and how they are called and labelled: its list says it, never its folder."""

import io
import json
import os
import unicodedata
from zipfile import ZIP_STORED, ZipFile

import pytest

from w2w.core.library.library import read_library
from w2w.web.study import Study

from ..headless.conftest import write_motions
from .conftest import made, sent


@pytest.fixture(scope="module")
def motion(made_once):
    """The bytes of a motion."""
    folder = made_once("one web motion", lambda folder: write_motions(folder, {"slow": 0.5}, 1))
    return (folder / "slow/slow_0.npz").read_bytes()


def study_at(address, tmp_path):
    return Study(tmp_path / "data/local" / address.rpartition("/")[2])


def labels_of(client, address):
    return {row["name"]: row.get("activity") for row in client.get(address).json()["table"]}


def broken_zip(motion, good=3):
    """A zip whose last member has a wrong check sum."""
    stream = io.BytesIO()
    with ZipFile(stream, "w", ZIP_STORED) as archive:
        for number in range(good + 1):
            archive.writestr(f"third/{number}.npz", motion + bytes([number]))
    content = bytearray(stream.getvalue())
    content[content.rindex(motion) + 100] ^= 255
    return bytes(content)


def test_a_zip_that_breaks_off_leaves_no_clip_behind(client, motion, tmp_path):
    address, reply = sent(client, {"clips.zip": broken_zip(motion)})
    assert "no zip that can be read" in reply.json()["refused"]["clips.zip"]
    sent(client, {"slow/a.npz": motion, "fast/b.npz": motion}, address)
    study = study_at(address, tmp_path)
    assert set(labels_of(client, address)) == {"slow/a.npz", "fast/b.npz"}
    assert set(study.library().activities) == {"slow", "fast"}
    assert {path.name for path in study.folder.iterdir()} - {"figures"} == {"input", "request.json"}


def test_what_a_killed_server_left_in_the_folder_never_runs(opened, motion, tmp_path):
    client = opened()
    address, _ = sent(client, {"slow/a.npz": motion, "fast/b.npz": motion})
    study = study_at(address, tmp_path)
    stray = study.folder / "input/third/c.npz"
    stray.parent.mkdir()
    stray.write_bytes(motion)
    arriving = study.folder / "arriving.0123"
    arriving.mkdir()
    study.checked({})
    assert set(study.library().activities) == {"slow", "fast"}
    opened()  # the next server
    assert not arriving.exists()


def test_other_scripts_stay_apart_on_disk_and_in_labels_as_in_a_run(client, motion, tmp_path):
    names = ["歩行/a.npz", "走る/a.npz", "Überkopf/ä.npz", "прогулка/a.npz", "مشي/a.npz"]
    address, reply = sent(client, dict.fromkeys(names, motion))
    assert reply.json()["refused"] == {}
    assert labels_of(client, address) == {name: name.split("/")[0].lower() for name in names}
    run = {clip.activity for clip in study_at(address, tmp_path).library().clips}
    for name in names:
        path = tmp_path / "library" / name
        path.parent.mkdir(parents=True)
        path.write_bytes(motion)
    assert run == set(read_library(tmp_path / "library").activities)


def test_a_name_in_pieces_is_one_with_its_composed_form(client, motion):
    pieces = unicodedata.normalize("NFD", "Gehen/süß.npz")
    address, _ = sent(client, {pieces: motion})
    sent(client, {"Gehen/süß.npz": motion}, address)
    assert list(labels_of(client, address)) == ["Gehen/süß.npz"]


def test_folders_that_no_disk_tells_apart_are_two_activities_of_the_run(client, motion, tmp_path):
    address, _ = sent(client, {"walk?/a.npz": motion, "walk*/a.npz": motion})
    study = study_at(address, tmp_path)
    study.checked({})
    assert {clip.activity for clip in study.library().clips} == {"walk?", "walk*"}
    assert f"--labels={study.edited}" in study.command(1, "")


def test_a_file_called_as_a_folder_is_kept_beside_it(client, motion):
    address, reply = sent(client, {"a.npz/b.npz": motion, "a.npz": motion})
    assert reply.json()["refused"] == {}
    assert set(labels_of(client, address)) == {"a.npz/b.npz", "a.npz"}


@pytest.mark.parametrize("letter", ["歩", "a"])
def test_a_name_as_long_as_may_be_is_kept(client, motion, letter):
    address, reply = sent(client, {f"{letter * 220}/{letter * 10}.npz": motion})
    assert reply.json()["refused"] == {}
    assert len(client.get(address).json()["table"]) == 1


def test_labels_sent_after_an_edit_go_over_it_for_the_clips_that_they_name(client, motion):
    address, _ = sent(client, {"x/a.npz": motion, "x/b.npz": motion})
    rows = [{"file": file, "activity": "typed", "subject": ""} for file in ("x/a.npz", "x/b.npz")]
    client.put(f"{address}/labels", json=rows)
    _, reply = sent(client, {"labels.csv": b"file,activity,subject\nx/a.npz,sent,Anna\n"}, address)
    assert labels_of(client, address) == {"x/a.npz": "sent", "x/b.npz": "typed"}
    assert reply.json()["said"] == (
        "labels.csv labelled 1 clip, over what was typed for them; 1 other clip kept what you typed."
    )


def test_labels_csv_names_clips_as_they_were_given(client, motion, tmp_path):
    labels = 'file,activity\n"walk?/a.npz",stroll\n歩行/b.npz,jump\n'.encode()
    address, _ = sent(client, {"walk?/a.npz": motion, "歩行/b.npz": motion, "labels.csv": labels})
    assert labels_of(client, address) == {"walk?/a.npz": "stroll", "歩行/b.npz": "jump"}
    study = study_at(address, tmp_path)
    study.checked({})
    assert set(study.library().activities) == {"stroll", "jump"}


def test_labels_that_look_like_formulas_stay_as_typed(client, motion):
    address, _ = sent(client, {"x/a.npz": motion, "@y/b.npz": motion})
    rows = client.get(address).json()["table"]
    client.put(f"{address}/labels", json=[row | {"activity": "+5 kg"} for row in rows])
    assert set(labels_of(client, address).values()) == {"+5 kg"}


def test_a_labels_csv_that_is_none_or_huge_is_refused_and_not_kept(client, motion):
    address, _ = sent(client, {"x/a.npz": motion})
    for content, why in ((b"a,b\n1,2\n", "needs the columns"), (b"file,activity\n" * 10**5, "larger than")):
        _, reply = sent(client, {"labels.csv": content}, address)
        assert why in reply.json()["refused"]["labels.csv"]
        assert labels_of(client, address) == {"x/a.npz": "x"}


def test_a_demo_of_an_earlier_version_keeps_its_labels(tmp_path):
    study = Study.make(tmp_path / "data/local", demo=True)
    request = json.loads((study.folder / "request.json").read_text())
    del request["sums"], request["files"]["labels.csv"]
    request |= {"asked": None, "judged": {}}
    (study.folder / "request.json").write_text(json.dumps(request))
    study.checked({})
    rows = study.table()[0]
    assert all(row["subject"] for row in rows)
    assert {(row["name"], row["activity"]) for row in rows} == {
        (clip.file, clip.activity) for clip in study.library().clips
    }
    assert len(rows) == len(study.library().clips)


def test_reasons_hold_no_paths_of_the_server(client, tmp_path):
    study = study_at(made(client), tmp_path)
    reason = f"{study.folder}/input/walk/a.bvh breaks off; see '/opt/w2w/site-packages/x/y.py' or /home/lab/z"
    said = study.without_paths(reason)
    assert said == "walk/a.bvh breaks off; see 'y.py' or z"
    assert (
        study.without_paths("12 frames/s, 9.8 m/s2 and/or 1 / 2 clips")
        == "12 frames/s, 9.8 m/s2 and/or 1 / 2 clips"
    )
    assert os.fspath(tmp_path) not in said
