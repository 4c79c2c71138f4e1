# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and sentences as people read them."""

from w2w.core.wording import capital, free_name, plain_words


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
