# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and sentences as people read them."""

import os

import pytest

from w2w.core.files import write_json, write_text
from w2w.core.library.library import read_library, unique_names
from w2w.core.wording import capital, clean, free_name, name_bytes, plain_words, shortened, wrapped


def test_only_the_first_letter_becomes_a_capital():
    assert capital(ValueError("an IMU of BROAD")) == "An IMU of BROAD"
    assert capital("") == ""
    assert capital("5 clips") == "5 clips"


def test_case_and_spaces_do_not_count_in_a_name():
    assert plain_words("  Strap   Pod ") == "strap pod"


def test_a_free_name_takes_the_first_free_number():
    assert free_name("ring", {"watch"}) == "ring"
    assert free_name("ring", {"ring", "ring 3"}) == "ring 2"
    assert free_name("ring", {"ring", "ring 001"}, "{} {:03d}", 1) == "ring 002"


def test_names_that_are_text_stay_as_they_are():
    assert clean("跑步/café.fbx") == "跑步/café.fbx"
    assert name_bytes("café") == "café".encode()


@pytest.mark.skipif(os.name == "nt", reason="names are always text there")
def test_other_bytes_are_spelt_out():
    assert clean("caf\udce9.fbx") == "caf%E9.fbx"
    in_the_c_locale = "café.fbx".encode().decode("ascii", "surrogateescape")
    assert clean(in_the_c_locale) == "café.fbx"
    assert unique_names([in_the_c_locale, "caf-.fbx"]) == unique_names(["café.fbx", "caf-.fbx"])


@pytest.mark.skipif(os.name == "nt", reason="names are always text there")
def test_a_library_of_such_names(tmp_path):
    library = os.fsencode(tmp_path / "library")
    for name in (b"gehen\xe4/a.fbx", b"gehen\xe4/\xff\xfe.fbx", "läuft/é.fbx".encode()):
        path = os.path.join(library, name)  # noqa: PTH118 - paths of bytes
        os.makedirs(os.path.dirname(path), exist_ok=True)  # noqa: PTH103, PTH120
        with open(path, "wb") as stream:  # noqa: PTH123
            stream.write(b"x")
    found = read_library(tmp_path / "library")
    assert [clip.file for clip in found.clips] == [
        "gehen%E4/a.fbx",
        "gehen%E4/%FF%FE.fbx",
        "läuft/é.fbx",
    ]
    assert found.activities == {"gehen%e4": 2, "läuft": 1}
    assert all(clip.path.read_bytes() == b"x" for clip in found.clips)
    assert len({clip.name for clip in found.clips}) == 3
    labels = tmp_path / "labels.csv"
    labels.write_text("file,activity\ngehen%E4/a.fbx,stroll\n%FF%FE.fbx,run\n", encoding="utf-8")
    listed = read_library(tmp_path / "library", labels)
    assert [clip.activity for clip in listed.clips] == ["stroll", "run"]
    assert dict(listed.skipped).keys() == {"läuft/é.fbx"}


def test_nothing_that_is_no_unicode_stops_a_result(tmp_path):
    write_text(tmp_path / "a.txt", "caf\udce9")
    assert (tmp_path / "a.txt").read_bytes() == b"caf\\udce9"
    write_json(tmp_path / "a.json", {"file": "caf\udce9 é"})
    assert (tmp_path / "a.json").read_bytes() == '{\n  "file": "caf\\udce9 é"\n}\n'.encode()


@pytest.mark.parametrize(
    ("name", "shown"), [("walk_001", "walk_001"), ("dataset-1_bow_active_001", "dat…ve_001"), ("", "")]
)
def test_names_that_are_too_wide_lose_their_middle(name, shown):
    assert shortened(name, 10, len) == shown


def test_lines_are_as_long_as_fits_and_no_word_is_broken():
    lines = ["one two", "three", "incomprehensible", "four"]
    assert wrapped(" ".join(lines), 9, len) == lines
    assert wrapped("", 9, len) == []
