# SPDX-License-Identifier: GPL-3.0-or-later
"""The tutorial on real clips prints what its page shows, from clips of HDM05 that are not part of W2W."""

import contextlib
import io
import re
import tarfile
from collections import Counter
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs" / "real_clips.md"
ACTIVITIES = ("jog", "kick", "rotate_arms", "squat", "throw")
NUMBER = re.compile(r"\d*\.\d+|\d+")


def some_clips(archive, folder):
    """The first two clips of each actor and activity, in a folder per activity."""
    taken = Counter()
    with tarfile.open(archive) as held:
        for member in sorted(held, key=lambda member: member.name):
            activity, _, name = member.name.removeprefix("./").rpartition("/")
            if activity in ACTIVITIES and taken[activity, name[:2]] < 2:
                taken[activity, name[:2]] += 1
                held.extract(member, folder, filter="data")


@pytest.mark.slow
@pytest.mark.usefixtures("all_orders")
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_the_page_shows_what_its_code_prints(shared_data, tmp_path, monkeypatch):
    some_clips(shared_data / "library" / "hdm05.tar.xz", tmp_path / "HDM05")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert len(blocks) == 5
    names: dict = {}
    for code, shown in blocks:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, PAGE.name, "exec"), names)
        assert NUMBER.sub("#", printed.getvalue()) == NUMBER.sub("#", shown)
        for found, said in zip(NUMBER.findall(printed.getvalue()), NUMBER.findall(shown), strict=True):
            assert float(found) == pytest.approx(float(said), abs=0.025)  # processors differ in the last bit
