# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that pauses, run through."""

from w2w.scene.pauses import without_pauses


def test_it_is_run_to_its_end_and_gives_what_it_comes_to():
    done = []

    def steps():
        for number in range(3):
            done.append(number)
            yield number
        return sum(done)

    assert without_pauses(steps()) == 3
    assert done == [0, 1, 2]
