# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that pauses, run through."""

import pytest

from w2w.scene.base.steps import scaled, without_pauses


def test_it_is_run_to_its_end_and_gives_what_it_comes_to():
    done = []

    def steps():
        for number in range(3):
            done.append(number)
            yield number
        return sum(done)

    assert without_pauses(steps()) == 3
    assert done == [0, 1, 2]


def test_steps_are_changed_as_they_come_and_the_result_is_kept():
    ended = []

    def halves():
        try:
            yield 0.5
            yield 1.0
            return "done"
        finally:
            ended.append(True)

    found = []

    def kept():
        found.append((yield from scaled(halves(), 0.2, 0.4)))

    assert list(kept()) == pytest.approx([0.3, 0.4])
    assert found == ["done"]
    closed = scaled(halves(), 0.0, 1.0)
    next(closed)
    closed.close()
    assert ended == [True, True]
