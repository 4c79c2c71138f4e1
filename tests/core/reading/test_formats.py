# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of motion files: what the page says of them, and readers of other packages."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.asf_amc import ASF_SUFFIX
from w2w.core.reading.formats import FORMATS, MOTION_SUFFIXES, TABLES, formats_of, read_motion

ROOT = Path(__file__).resolve().parents[3]

READER = """
from w2w.core.body.body import Body
from w2w.core.motion.examples import demo_motions
from w2w.core.reading.formats import Format

def read(path, pose, ups, animation):
    if path.read_text() == "end":
        import os
        os._exit(1)
    return next(iter(demo_motions(1).values())).labelled("", "", "")

WALKS = Format("walks", (".walk",), read, up="z", version=VERSION)
TAKEN = Format("ours", (".walk", ".bvh"), read)
NOTHING = 3
"""

POINTS = """[w2w.readers]
broken = walks_of_mine:GONE
mine = walks_of_mine:WALKS
nothing = walks_of_mine:NOTHING
taken = walks_of_mine:TAKEN
"""

ASKED = """
import sys
from pathlib import Path
import w2w
from w2w.core.library.library import Clip
from w2w.core.reading.formats import FAULTS
from w2w.core.study.config import StudyConfig
from w2w.headless.runs.clip_task import ClipTask
motions = w2w.load(sys.argv[1])
print([motion.clip for motion in motions], dict(motions.skipped))
print(*FAULTS, sep="\\n")
file = Path(sys.argv[1], "waving/a.walk")
print("key", ClipTask(Clip(file, "a.walk", "a", "waving"), Path(), StudyConfig(), "").key(""))
"""


@pytest.fixture
def installed(tmp_path):
    """A package on a path of its own that adds a reader; its version can be set."""

    def install(version):
        site, info = tmp_path / "site", tmp_path / "site" / "walks_of_mine-1.5.dist-info"
        info.mkdir(parents=True, exist_ok=True)
        (site / "walks_of_mine.py").write_text(READER.replace("VERSION", repr(version)))
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: walks-of-mine\nVersion: 1.5\n")
        (info / "entry_points.txt").write_text(POINTS)
        asked = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(site)!r})\n{ASKED}"]
        done = subprocess.run([*asked, tmp_path / "library"], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()

    return install


@pytest.mark.later
def test_another_package_reads_its_files_and_one_that_cannot_costs_a_sentence(tmp_path, installed):
    (tmp_path / "library/waving").mkdir(parents=True)
    for name in ("a", "b", "end"):
        (tmp_path / "library/waving" / f"{name}.walk").write_text(name)
    clips, *faults, key = installed("1")
    assert clips.startswith("['waving_a', 'waving_b'] {'waving/end.walk': 'the program that reads it crashed")
    assert len(faults) == 3
    assert faults[0].startswith("the reader 'broken' cannot be used: ")
    assert faults[1] == (
        "the reader 'nothing' cannot be used: walks_of_mine:NOTHING is no Format with a reader and suffixes"
    )
    assert faults[2] == "the reader 'taken' cannot be used: .bvh and .walk is read already"
    assert installed("1")[-1] == key
    assert installed("2.0")[-1] != key  # of another size: Python compares no more than that within a second


def test_the_page_lists_the_suffixes_that_are_read():
    page = (ROOT / "docs/motion_files.md").read_text(encoding="utf-8")
    table = page[page.index("| format | notes |") : page.index("\n\n", page.index("| format | notes |"))]
    listed = set(re.findall(r"`(\.[a-z0-9]+)`", table))
    listed |= {f".{kind}" for kind in re.findall(r"\b(npy|npz|csv|json|trc|c3d)\b", table.splitlines()[-1])}
    assert listed - {ASF_SUFFIX} == {*MOTION_SUFFIXES, *TABLES}


def test_of_kinds_with_one_suffix_all_but_the_last_tell_their_files():
    for suffix in (*MOTION_SUFFIXES, *TABLES):
        kinds = formats_of(Path(f"a{suffix.upper()}"))
        assert kinds
        assert all(kind.holds or kind.name == "poselib" for kind in kinds[:-1]), suffix
    assert len({kind.name for kind in FORMATS}) == len(FORMATS)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("a.xyz", r"'\.xyz' is not a kind of motion file that can be read \(\.fbx, \.bvh, "),
        ("a.mot", "angles of an OpenSim model"),
        ("a.fbx", "Blender reads it, and was not asked"),
    ],
)
def test_a_file_that_nobody_reads_is_refused_with_what_to_do(tmp_path, name, reason):
    with pytest.raises(UnusableMotion, match=reason):
        read_motion(tmp_path / name)
