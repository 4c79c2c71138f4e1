# SPDX-License-Identifier: GPL-3.0-or-later
"""Which clips a folder holds, and what labels them."""

import json
import unicodedata

import pytest
from hypothesis import given, settings, strategies as st

from w2w.core.library.library import LibraryError, activity_of, not_read_sentence, read_library, unique_names


@pytest.fixture
def folder(tmp_path):
    for file in (
        "walking/a.fbx",
        "walking/b.FBX",
        "Sit To Stand/clip (3).bvh",
        "X Bot@Waving (2).fbx",
        "notes.txt",
    ):
        path = tmp_path / "library" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"")
    return tmp_path / "library"


@pytest.mark.parametrize(
    ("file", "activity"),
    [
        ("Walking (2).fbx", "walking"),
        ("X Bot@Waving.fbx", "waving"),
        ("Sit To Stand.fbx", "sit_to_stand"),
        ("running/clip 7.fbx", "running"),
        ("subject 1/Jumping Jacks/01.bvh", "jumping_jacks"),
        ("aj@Pull Heavy Object (12).fbx", "pull_heavy_object"),
        ("跑步.fbx", "跑步"),
    ],
)
def test_labels_from_folders_and_file_names(file, activity):
    assert activity_of(file) == activity


def test_folders_label_before_file_names(folder):
    library = read_library(folder)
    assert library.activities == {"sit_to_stand": 1, "walking": 2, "waving": 1}
    assert library.labelled_by == "folder names and file names"


def test_a_csv_labels_what_it_lists_and_the_rest_is_said(folder, tmp_path):
    labels = tmp_path / "labels.csv"
    labels.write_text(
        'File,Activity,Subject\nwalking/a.fbx,"stroll, slow",Ünal\nb.FBX,run,\n', encoding="utf-8-sig"
    )
    library = read_library(folder, labels)
    assert [(clip.file, clip.activity, clip.subject) for clip in library.clips] == [
        ("walking/a.fbx", "stroll, slow", "Ünal"),
        ("walking/b.FBX", "run", ""),
    ]
    assert {reason for _, reason in library.skipped} == {"labels.csv does not list it"}


def test_paths_may_carry_folders_above_the_library(folder, tmp_path):
    labels = tmp_path / "labels.csv"
    labels.write_text("file,activity\nsomewhere/library/walking/a.fbx,stroll\n")
    assert [clip.file for clip in read_library(folder, labels).clips] == ["walking/a.fbx"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,label\na,b\n", "needs the columns"),
        ("", "needs the columns"),
        ("file,activity\nother.fbx,run\n", "lists none"),
        ("file,activity\nwalking/a.fbx,run\nwalking/a.fbx,walk\n", "listed twice"),
        ("file,activity,subject\nwalking/a.fbx,run,ann\nwalking/a.fbx,run,bob\n", "listed twice"),
    ],
)
def test_a_csv_that_cannot_be_understood_is_refused(folder, tmp_path, text, message):
    labels = tmp_path / "labels.csv"
    labels.write_text(text)
    with pytest.raises(LibraryError, match=message):
        read_library(folder, labels)


def test_an_ambiguous_file_name_is_refused(folder, tmp_path):
    (folder / "other").mkdir()
    (folder / "other/a.fbx").write_bytes(b"")
    labels = tmp_path / "labels.csv"
    labels.write_text("file,activity\na.fbx,run\n")
    with pytest.raises(LibraryError, match="could be any of"):
        read_library(folder, labels)


def test_missing_and_empty_folders_are_refused(tmp_path):
    with pytest.raises(LibraryError, match="not a folder"):
        read_library(tmp_path / "nowhere")
    with pytest.raises(LibraryError, match="no motion files"):
        read_library(tmp_path)


@settings(max_examples=40)
@given(st.sets(st.text(min_size=1, max_size=8).filter(lambda text: text not in (".", "..")), max_size=8))
def test_names_are_safe_and_distinct_even_without_case(stems):
    files = [f"{stem.replace('/', '_')}.fbx" for stem in stems]
    files = list(dict.fromkeys(files))
    names = unique_names(files)
    assert len({name.lower() for name in names}) == len(files)
    assert all(
        name and set(name) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_")
        for name in names
    )


def test_no_file_is_called_what_another_is_hashed_to(tmp_path):
    files = ["walk/a b.bvh", "walk/a_b.bvh"]
    for _ in range(4):  # each round a file more, which bears a name of those before it
        files += [f"{name}.bvh" for name in unique_names(files) if f"{name}.bvh" not in files]
        names = unique_names(files)
        assert len({name.lower() for name in names}) == len(files)
    for file in files[:6]:
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).touch()
    clips = read_library(tmp_path).clips
    assert len({clip.name for clip in clips}) == len(clips) == 6


@pytest.mark.parametrize("name", ["CON", "nul", "aux", "Prn", "COM1", "lpt9"])
def test_no_name_is_one_that_windows_keeps_for_devices(name):
    (safe,) = unique_names([f"{name}.fbx"])
    assert safe.lower() != name.lower()
    assert safe.startswith(f"{name}_")


def test_path_tricks_stay_inside():
    assert unique_names(["../../etc/passwd.fbx", "a/../b.fbx"]) == ["etc_passwd", "a_b"]


def test_what_a_run_left_in_the_library_is_no_clip(tmp_path):
    for file in ("a.fbx", "own/b.npz", "out/.w2w/c.npz", "out/motions/d.npz", "out/utility.npz", "out/e.bvh"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).touch()
    assert [clip.file for clip in read_library(tmp_path).clips] == ["a.fbx", "out/e.bvh", "own/b.npz"]
    assert [clip.file for clip in read_library(tmp_path / "out" / "motions").clips] == ["d.npz"]


def test_labels_that_lie_in_the_library_label_it(tmp_path):
    for file in ("walk/a.bvh", "walk/b.bvh"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).touch()
    (tmp_path / "labels.csv").write_text("file,activity,subject\na.bvh,stroll,Anna\n")
    library = read_library(tmp_path)
    assert library.labelled_by == "the file labels.csv in the library"
    assert [(clip.file, clip.activity, clip.subject) for clip in library.clips] == [
        ("walk/a.bvh", "stroll", "Anna")
    ]
    assert library.skipped == (("walk/b.bvh", "labels.csv does not list it"),)
    assert read_library(tmp_path, own_labels=False).activities == {"walk": 2}
    other = tmp_path / "other.csv"
    other.write_text("file,activity\na.bvh,amble\nb.bvh,amble\n")
    assert read_library(tmp_path, other).activities == {"amble": 2}
    (tmp_path / "labels.csv").write_text("clip,label\na,stroll\n")
    with pytest.raises(LibraryError, match=r"needs the columns .* rename it, or give others"):
        read_library(tmp_path)


def test_folders_without_a_word_have_their_names_and_those_of_one_word_are_one(tmp_path):
    files = ["(1)/a.bvh", "(2)/b.bvh", "_/c.bvh", "Straße/d.bvh", "STRASSE/e.bvh", "f@(3).bvh", " /(4).bvh"]
    files += [f"{unicodedata.normalize(form, 'Läufe')}/g.bvh" for form in ("NFC", "NFD")]
    for file in files:
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).touch()
    library = read_library(tmp_path)
    assert library.activities == {"(1)": 1, "(2)": 1, "_": 1, "f": 1, "strasse": 2, "läufe": 2}
    assert library.skipped == ((" /(4).bvh", "neither its folder nor its name says what it shows"),)
    assert library.check.spellings == (("läufe", ("Läufe",)), ("strasse", ("STRASSE", "Straße")))
    kept = read_library(tmp_path, exact_labels=True).activities
    assert kept == {"(1)": 1, "(2)": 1, "_": 1, "f": 1, "Läufe": 2, "STRASSE": 1, "Straße": 1}


def test_files_of_kinds_that_are_not_read_are_counted_with_the_way_out(tmp_path):
    for name in ("a.mot", "b.mot", "film.mp4", "README", ".hidden.mot", "walk.bvh", "notes.csv"):
        (tmp_path / name).touch()
    found = read_library(tmp_path)
    assert dict(found.unread) == {".mot": 2, ".mp4": 1}
    assert not_read_sentence(found.unread) == (
        "3 files of kinds that are not read: 2 .mot and 1 .mp4; mot and sto hold the angles of an OpenSim "
        "model: take the trc that they were made from, if it has joint centres (OpenCap, Pose2Sim); videos "
        "need a pose estimator, whose results are read"
    )
    (tmp_path / "walk.bvh").unlink()
    with pytest.raises(LibraryError, match=r"holds no motion files .*; 3 files of kinds that are not read"):
        read_library(tmp_path)


@pytest.fixture
def pack(folder):
    """The library with a file of two animations in a folder."""
    channel = {"sampler": 0, "target": {"node": 0, "path": "rotation"}}
    animations = [
        {"name": f"Rig|{name}", "channels": [channel], "samplers": []} for name in ("Run", "Jump/Up")
    ]
    content = {"asset": {"version": "2.0"}, "nodes": [{"name": "Hips"}], "animations": animations}
    (folder / "heroes").mkdir()
    (folder / "heroes" / "pack.gltf").write_text(json.dumps(content))
    return folder


def test_each_animation_of_a_file_is_a_clip_named_after_it(pack):
    library = read_library(pack)
    assert library.activities == {"jump/up": 1, "run": 1, "sit_to_stand": 1, "walking": 2, "waving": 1}
    assert library.labelled_by == "names of animations, folder names and file names"
    path = pack / "heroes" / "pack.gltf"
    found = [clip for clip in library.clips if clip.animation]
    assert [(clip.path, clip.file, clip.name, clip.animation) for clip in found] == [
        (path, "heroes/pack.gltf/Run", "heroes_pack_gltf_Run", "Rig|Run"),
        (path, "heroes/pack.gltf/Jump/Up", "heroes_pack_gltf_Jump_Up", "Rig|Jump/Up"),
    ]
    assert all(clip.needs_blender for clip in found)


@pytest.mark.parametrize(
    ("rows", "labels"),
    [
        ("pack.gltf,play", {"Run": "play", "Jump/Up": "play"}),
        ("heroes/pack.gltf/Run,jog", {"Run": "jog"}),
        ("Run,jog\nheroes/pack.gltf,play", {"Run": "jog", "Jump/Up": "play"}),
    ],
)
def test_a_csv_labels_animations_one_by_one_or_together(pack, tmp_path, rows, labels):
    (tmp_path / "labels.csv").write_text(f"file,activity\na.fbx,walk\n{rows}\n")
    library = read_library(pack, tmp_path / "labels.csv")
    found = {clip.file: clip.activity for clip in library.clips if clip.animation}
    assert found == {f"heroes/pack.gltf/{name}": label for name, label in labels.items()}
    unlisted = {f"heroes/pack.gltf/{name}" for name in {"Run", "Jump/Up"} - labels.keys()}
    assert {file for file in library.check.not_listed if "pack" in file} == unlisted
    assert library.check.no_such_file == ()


def test_hidden_folders_hold_no_clips(tmp_path):
    for file in ("a.bvh", ".venv/lib/tests/b.bvh", "walking/.cache/c.bvh", "walking/d.bvh"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).touch()
    assert [clip.file for clip in read_library(tmp_path).clips] == ["a.bvh", "walking/d.bvh"]
    assert [clip.file for clip in read_library(tmp_path / ".venv").clips] == ["lib/tests/b.bvh"]


def test_folders_that_may_be_of_people_are_said(tmp_path):
    for file in ("anna/Squat well 1", "anna/walking", "ben/squat_well_2", "ben/Walking (2)", "ben/odd"):
        path = tmp_path / f"{file}.bvh"
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"")
    note = read_library(tmp_path).check.note
    assert note.startswith("folders hold clips of the same names, squat_well and walking: if")
    assert not read_library(tmp_path / "ben").check.note


def test_folders_of_activities_need_no_word(tmp_path):
    for file in ("walk/clip 1", "walk/clip 2", "run/clip 1", "run/Sprint", "run/Jog", "walk/Stroll"):
        path = tmp_path / f"{file}.bvh"
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"")
    assert not read_library(tmp_path).check.note
