# SPDX-License-Identifier: GPL-3.0-or-later
"""People by their names: a token may change, its studies stay; only hashes lie on the disk."""

import pytest

from w2w.web.guard import Doors, People
from w2w.web.serve import unseen
from w2w.web.study import Study
from w2w.web.work import Work

from ..command_line import cli


def doors(people, tokens=()):
    return Doors("127.0.0.1", (), tokens, 10**6, people)


def test_each_person_has_a_folder_that_a_new_token_leads_to_again(tmp_path):
    people = People(tmp_path / "people")
    first, other = people.invite("Anna Ö."), people.invite("Bert")
    folder = doors(people).owner(first)
    assert len({folder, doors(people).owner(other), ""}) == 3
    assert first not in people.file.read_text()
    again = people.invite("Anna Ö.")
    assert doors(people).owner(again) == folder
    assert doors(people).owner(first) == doors(people).owner("") == doors(people).owner("wrong") == ""


@pytest.mark.parametrize("name", ["", " ", "a\tb", "a\nb", "# a"])
def test_a_name_that_is_none_is_refused(tmp_path, name):
    with pytest.raises(ValueError, match="no name of a person"):
        People(tmp_path / "people").invite(name)


def test_a_token_that_changes_hides_nothing_without_a_word(tmp_path):
    work = Work(tmp_path, 1, "", 30.0)
    Study.make(tmp_path / "local")
    assert unseen(work, doors(People(None))) == ""
    assert unseen(work, doors(People(None), ["a-new-token"])) == f"1 study in {tmp_path} is of another token"


def test_an_invitation_prints_a_link_whose_token_no_log_holds(tmp_path):
    code, output = cli("serve", "--data", tmp_path, "--invite", "Anna")[:2]
    assert code == 0
    token = output.partition("/#token=")[2].strip()
    assert doors(People(tmp_path / "people")).owner(token)
