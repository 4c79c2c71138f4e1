# SPDX-License-Identifier: GPL-3.0-or-later
"""Labels from csv files as people's programs save them, and what in them is of no use."""

import csv
import re
import unicodedata

import pytest

from w2w.core.findings.notes import label_notes
from w2w.core.library.import_plan import BY_CSV, plan_files
from w2w.core.library.labels import LibraryError, by_label, same_label, speller
from w2w.core.library.library import read_library

ROWS = (("file", "activity", "subject"), ("a.fbx", "Gehen, müde", "Zoë"), ("b.fbx", "Laufen", "Jörg"))


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "library").mkdir()
    for name in "abcd":
        (tmp_path / "library" / f"{name}.fbx").write_bytes(b"")
    return tmp_path / "library"


@pytest.fixture
def labelled(folder, tmp_path):
    """The library, labelled by a csv of this text or these bytes."""

    def read(content, **options):
        path = tmp_path / "labels.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_library(folder, path, **options)

    return read


@pytest.mark.parametrize("separator", [",", ";", "\t", "|"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"])
@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r"])
def test_any_separator_and_any_unicode_works(labelled, separator, encoding, line_end):
    lines = [separator.join(f'"{cell}"' for cell in row) for row in ROWS]
    library = labelled((line_end.join(lines) + line_end).encode(encoding))
    assert [(clip.file, clip.activity, clip.subject) for clip in library.clips] == list(ROWS[1:])
    assert library.check.note == ""


def test_a_rate_is_the_file_s_own(labelled):
    table = "file;activity;rate\na.fbx;walking;29,97\nb.fbx;walking;\nc.fbx;running;120\n"
    assert [clip.rate for clip in labelled(table).clips] == [29.97, 0, 120]
    assert [clip.rate for clip in labelled("file,activity\na.fbx,walking\n").clips] == [0]
    with pytest.raises(LibraryError, match=r"'a\.fbx' is listed twice with different labels"):
        labelled("file,activity,rate\na.fbx,walking,30\na.fbx,walking,60\n")


@pytest.mark.parametrize("rate", ["fast", "0", "-30", "0.5", "nan", "inf", "1e9", "30 fps"])
def test_a_rate_that_is_none_is_a_sentence(labelled, rate):
    said = f"labels.csv, line 3: the rate is '{rate}'; it is in frames a second, 1 to 2,000, such as 30, or"
    with pytest.raises(LibraryError, match=re.escape(said)):
        labelled(f"file,activity,rate\na.fbx,walking,30\nb.fbx,walking,{rate}\n")


@pytest.mark.parametrize("encoding", ["latin-1", "cp1252"])
def test_western_text_is_read_and_said(labelled, encoding):
    library = labelled("\n".join(";".join(row) for row in ROWS).encode(encoding))
    assert [clip.subject for clip in library.clips] == ["Zoë", "Jörg"]
    assert library.check.note.startswith("labels.csv is not UTF-8 text and was read as Windows-1252")


def test_excels_own_line_on_the_separator_is_no_header(labelled):
    library = labelled("sep=;\r\nfile;activity\r\na.fbx;walking\r\nb.fbx\r\n")
    assert library.activities == {"walking": 1}
    assert library.check.no_activity == ("b.fbx",)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"file,activity,Activity\na.fbx,walk,run\n", "has the column 'activity' 2 times: keep one"),
        (b"PK\x03\x04 and so on", "workbook, not a csv file: save it as CSV"),
        (b"\xd0\xcf\x11\xe0", "workbook"),
        (b"\xff\xfea", "no text"),
        (
            "name;label\na;b\n",
            r"columns 'file' and 'activity' .* has: name;label .* semicolons, tabs or bars",
        ),
        ('file,activity\na.fbx,"walking\nb.fbx,running\n', "line 3, cannot be read as csv"),
        ("file,activity\nother.fbx,run\n", r"none of the 4 .* lists 'other.fbx', say, .* holds 'a.fbx'"),
        ("file,activity\na.fbx,\n", "1 rows have no file or no activity"),
    ],
)
def test_what_cannot_be_read_is_said(labelled, content, message):
    with pytest.raises(LibraryError, match=message):
        labelled(content)


def test_spellings_of_one_activity_are_one_and_are_named(labelled):
    text = "file,activity\na.fbx,Walking\nb.fbx,walking\nc.fbx,Sit to  Stand\nd.fbx,sit_to_stand\n"
    library = labelled(text)
    assert library.activities == {"sit_to_stand": 2, "walking": 2}
    assert library.check.spellings == (
        ("sit_to_stand", ("sit_to_stand", "Sit to  Stand")),
        ("walking", ("walking", "Walking")),
    )
    assert not library.check.exact


def test_the_commonest_spelling_stands(labelled):
    library = labelled("file,activity\na.fbx,Jumping Jack\nb.fbx,Jumping Jack\nc.fbx,jumping jack\n")
    assert library.activities == {"Jumping Jack": 3}


def test_spellings_are_kept_apart_where_asked(labelled):
    library = labelled("file,activity\na.fbx,Walking\nb.fbx,walking\n", exact_labels=True)
    assert library.activities == {"Walking": 1, "walking": 1}
    assert library.check.spellings == (("walking", ("walking", "Walking")),)
    assert library.check.exact


def test_one_person_is_one_subject_however_spelled(labelled):
    rows = "a.fbx,walk,Anna\nb.fbx,walk, anna \nc.fbx,walk,ANNA\nd.fbx,walk,Anna"
    library = labelled(f"file,activity,subject\n{rows}\n")
    assert {clip.subject for clip in library.clips} == {"Anna"}
    assert library.check.subjects == (("Anna", ("Anna", "anna", "ANNA")),)
    assert label_notes(library.check) == ["'Anna', 'anna' and 'ANNA' count as one subject, 'Anna'."]
    kept = labelled(f"file,activity,subject\n{rows}\n", exact_labels=True)
    assert {clip.subject for clip in kept.clips} == {"Anna"}


@pytest.mark.parametrize("exact", [False, True])
def test_letters_of_two_encodings_are_one(labelled, exact):
    one, other = (unicodedata.normalize(form, "école") for form in ("NFC", "NFD"))
    text = f"file,activity\na.fbx,{other}\nb.fbx,{one}\nc.fbx,{other}\n"
    library = labelled(text, exact_labels=exact)
    assert library.activities == {one: 3}
    (note,) = label_notes(library.check)[:1]
    assert note == f"'{one}' is encoded in two ways that look the same, and counts as one activity."


def test_what_nobody_sees_makes_no_other_person(labelled):
    library = labelled(
        "file,activity,subject\na.fbx,walk,Anna\nb.fbx,walk\u200b,\ufeffAnna\nc.fbx,walk,Anna\u00a0\n"
    )
    assert library.activities == {"walk": 3}
    assert {clip.subject for clip in library.clips} == {"Anna"}


def test_labels_are_of_files_of_another_encoding_case_or_spacing(tmp_path):
    for name in ("läufe/Geh 1.bvh", "läufe/GEH 2.bvh", "same.bvh", "Same.bvh"):
        path = tmp_path / "library" / unicodedata.normalize("NFD", name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    rows = "Läufe/geh  1.bvh,walk\ngeh 2.BVH,walk\nsame.bvh,run\nSame.bvh,hop\n"
    (tmp_path / "labels.csv").write_text(f"file,activity\n{rows}", encoding="utf-8")
    library = read_library(tmp_path / "library", tmp_path / "labels.csv")
    found = {clip.path.name: clip.activity for clip in library.clips}
    assert found == {"Geh 1.bvh": "walk", "GEH 2.bvh": "walk", "same.bvh": "run", "Same.bvh": "hop"}
    (tmp_path / "labels.csv").write_text("file,activity\nSAME.bvh,run\n", encoding="utf-8")
    with pytest.raises(LibraryError, match=r"'SAME.bvh' could be any of Same.bvh, same.bvh"):
        read_library(tmp_path / "library", tmp_path / "labels.csv")


def test_a_file_listed_twice_with_one_label_in_two_spellings_is_no_conflict(labelled):
    library = labelled("file,activity\na.fbx,Sit-down\na.fbx,sit down\nb.fbx,Sit-down\n")
    assert len(library.clips) == 2


def test_no_control_character_of_a_cell_is_part_of_a_label(labelled):
    library = labelled('file,activity,subject\na.fbx,"w\x1b]0;x\x07alk","An\nna"\nb.fbx,run,\u202eb\n')
    assert library.activities == {"run": 1, "w%1B]0;x%07alk": 1}
    assert {clip.subject for clip in library.clips} == {"An na", "%E2%80%AEb"}


def test_the_escapes_of_a_received_csv_are_shown_harmlessly(shared_cases):
    library = read_library(shared_cases / "v1", shared_cases / "esc.csv")
    assert library.activities == {"run": 2, "wa%1B]0;pwned%07%1B[2Jlk": 2}


def test_rows_and_files_without_each_other_are_named(labelled):
    library = labelled("file,activity\na.fbx,walking\nb.fbx,\n,running\nx.fbx,walking\ny/z.fbx,running\n")
    assert [clip.file for clip in library.clips] == ["a.fbx"]
    check = library.check
    assert check.no_such_file == ("x.fbx", "y/z.fbx")
    assert check.no_activity == ("b.fbx", "line 4")
    assert check.not_listed == ("c.fbx", "d.fbx")
    assert dict(library.skipped) == {
        "b.fbx": "labels.csv gives it no activity",
        "c.fbx": "labels.csv does not list it",
        "d.fbx": "labels.csv does not list it",
    }


def test_labels_are_found_whatever_their_spelling():
    assert same_label("  Sit \t to__Stand ") == same_label("sit to stand") == "sit_to_stand"
    assert by_label({"Walking": "one", "run": "two"}, ["walking", "run", "sit"]) == {
        "walking": "one",
        "run": "two",
    }
    assert by_label({"Walking": "one", "walking": "two"}, ["Walking"]) == {"Walking": "one"}


def test_where_the_labels_lie_is_not_told(labelled):
    assert labelled("file,activity\na.fbx,walking\n").labelled_by == "the file labels.csv"


@pytest.mark.parametrize(("separator", "encoding"), [(";", "utf-16"), ("\t", "utf-8-sig"), (";", "cp1252")])
def test_real_labels_say_the_same_however_they_are_saved(shared_data, tmp_path, separator, encoding):
    with (shared_data / "motions.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    saved = tmp_path / "motions.csv"
    with saved.open("w", newline="", encoding=encoding, errors="replace") as stream:
        csv.writer(stream, delimiter=separator).writerows(rows)
    expected, found = (read_library(shared_data, labels) for labels in (shared_data / "motions.csv", saved))
    assert len(found.clips) > 100
    assert found.activities == expected.activities
    assert [clip.file for clip in found.clips] == [clip.file for clip in expected.clips]
    assert found.check.not_listed == expected.check.not_listed


def test_a_column_may_name_the_source(labelled):
    library = labelled("file,activity,source\na.fbx,walk,studio\nb.fbx,walk,\n")
    assert [clip.source for clip in library.clips] == ["studio", ""]
    assert [clip.source for clip in labelled("file,activity\na.fbx,walk\n").clips] == [""]


@pytest.fixture
def people(tmp_path):
    """A library of two people, each with a file of the same name, and one with a file more."""
    for file in ("subject01/001.bvh", "subject02/001.bvh", "subject02/002.bvh", "003.bvh"):
        (tmp_path / "people" / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "people" / file).touch()
    return tmp_path / "people"


@pytest.mark.parametrize(
    ("folder", "row", "file"),
    [
        ("people", "subject01/002.bvh", None),
        ("people", "subject01/003.bvh", None),
        ("people/subject02", "subject01/001.bvh", None),
        ("people/subject02", "other/people/001.bvh", None),
        ("people", "002.bvh", "subject02/002.bvh"),
        ("people", "./subject02\\001.bvh", "subject02/001.bvh"),
        ("people", "/home/ann/people/subject02/001.bvh", "subject02/001.bvh"),
        ("people", "../people/003.bvh", "003.bvh"),
        ("people/subject02", "people/subject02/001.bvh", "001.bvh"),
        (".", "subject02/001.bvh", "people/subject02/001.bvh"),
    ],
)
def test_a_folder_in_a_row_is_the_files_own(people, folder, row, file):
    labels = people.parent / "labels.csv"
    labels.write_text(f"file,activity\n{row},walk\n")
    inside = people.parent / folder
    if file is None:
        with pytest.raises(LibraryError, match="lists none of"):
            read_library(inside, labels)
    else:
        assert [clip.file for clip in read_library(inside, labels).clips] == [file]


def test_an_end_of_several_paths_is_refused(people):
    labels = people.parent / "labels.csv"
    labels.write_text("file,activity\n001.bvh,walk\n")
    with pytest.raises(LibraryError, match=r"could be any of subject01/001.bvh, subject02/001.bvh"):
        read_library(people, labels)


def test_files_chosen_by_hand_are_labelled_by_their_own_rows(people):
    labels = people / "labels.csv"
    labels.write_text("file,activity\nsubject01/001.bvh,walk\nsubject02/001.bvh,run\n")
    (clip,) = plan_files([people / "subject02" / "001.bvh"], BY_CSV, labels).clips
    assert clip.activity == "run"


def test_a_label_is_spelled_as_it_is_listed():
    spell = speller(["Sit down", "sit_down", "walk"])
    assert [spell(typed) for typed in ("sit-down", "WALK", " jump ")] == ["Sit down", "walk", "jump"]
