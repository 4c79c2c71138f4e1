# SPDX-License-Identifier: GPL-3.0-or-later
"""What the first look at a library may cost, whatever its files do."""

import pytest

from w2w.core.motion.examples import demo_motions
from w2w.core.reading import look
from w2w.core.reading.look import look_up
from w2w.core.reading.reader import LOOK_SHARE, Death, Reader


class Hanging(Reader):
    """A reader that is outlasted by each risky file, without the wait."""

    def __init__(self, limit_s):
        super().__init__(limit_s)
        self.limits = []

    def call(self, path, _work):
        self.limits.append(self.limit_s)
        self.lost_s += self.limit_s
        self.deadly[path] = Death("too long", [])
        raise ValueError("too long")


@pytest.fixture
def library(tmp_path):
    """Forty files that hang, and motions of three people; each with its name in the library."""
    files = [tmp_path / f"{number:02d}.c3d" for number in range(40)]
    for file in files:
        file.write_bytes(b"C3D")
    for number, motion in enumerate(demo_motions(3).values()):
        motion.save(files[0].with_name(f"seen_{number}.npz"))
    return [(path.name, path) for path in sorted(tmp_path.iterdir())]


def test_files_that_hang_take_no_longer_together_than_one_clip_may(library):
    reader = Hanging(300.0)
    look_up(reader, library)
    assert reader.limits == [300.0 / LOOK_SHARE] * LOOK_SHARE
    assert reader.lost_s == reader.limit_s == 300.0


def test_a_large_file_is_not_looked_at(library, monkeypatch):
    monkeypatch.setattr(look, "MOST_SAMPLE_BYTES", 2)
    look_up(reader := Hanging(300.0), library)
    assert not reader.limits
