# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that a folder's own files give never lead out of it."""

import os

import pytest

from w2w.core.given import ForeignFileError, checked, file_name, inside

LEADING_OUT = [
    *("", ".", "..", "../a", "a/..", "a/../../b", "./a", "a//b", "a/", "/a", "/", "...", ".. /a", ". ./a"),
    *("C:\\a", "C:a", "\\\\host\\share", "\\a", "a\\..\\b", "a\0b", "a\nb", "\x1b[2J", 7, None, ["a"]),
]


@pytest.mark.parametrize("name", LEADING_OUT, ids=ascii)
def test_a_name_that_leads_out_is_refused_with_its_source(tmp_path, name):
    with pytest.raises(ForeignFileError, match=r"^the list, line 3, names .*, which leads out of the folder"):
        checked(name, "the list, line 3,")
    with pytest.raises(ForeignFileError, match=r" names .*, which leads out of the folder"):
        inside(tmp_path, name)


@pytest.mark.parametrize("name", ["a", "a/b.npz", ".w2w/clips/a.json", "..a", "a..", "Sit (1).fbx", "\xe9"])
def test_a_name_in_the_folder_is_its_path(tmp_path, name):
    assert inside(tmp_path, name) == tmp_path / name


def test_links_may_lead_about_the_folder_and_not_out_of_it(tmp_path):
    out, elsewhere = tmp_path / "out", tmp_path / "elsewhere"
    for folder in (out / "real", elsewhere):
        folder.mkdir(parents=True)
        (folder / "a").write_text("a")
    links = {"within": "real", "away": elsewhere, "up": "..", "nowhere": tmp_path / "gone", "chain": "away"}
    for name, target in links.items():
        (out / name).symlink_to(target)
    assert inside(out, "within/a").read_text() == "a"
    for name in ("away", "away/a", "up/elsewhere/a", "nowhere", "nowhere/a", "chain/a"):
        with pytest.raises(ForeignFileError, match="is a link that leads out of the folder"):
            inside(out, name)
    (tmp_path / "link").symlink_to(out)
    assert inside(tmp_path / "link", "real/a").read_text() == "a"


def test_a_folder_beside_whose_name_begins_alike_is_outside(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out2").mkdir()
    (tmp_path / "out" / "a").symlink_to(tmp_path / "out2")
    with pytest.raises(ForeignFileError):
        inside(tmp_path / "out", "a/b")


def test_a_pipe_is_never_opened(tmp_path):
    os.mkfifo(tmp_path / "summary.json")
    with pytest.raises(ForeignFileError, match="is a pipe or a device"):
        inside(tmp_path, "summary.json")


def test_a_placement_may_be_called_as_no_file_can():
    assert file_name(" left  wrist") == "left_wrist"
    assert file_name('../a\\b:c*"?<>|') == ".._a_b_c_"
