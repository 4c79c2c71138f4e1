# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder begun with many clips divides them among sub-folders, and gives the same results."""

import shutil

import pytest

from w2w.core.study.clip_files import motion_file
from w2w.core.study.results import StudyResults
from w2w.headless.runs import folder

from ...command_line import cli

OPTIONS = "--patches 8 --workers 1 --no-pictures --no-report --folds 2 --window 1".split()

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("one_worker", "few_orders")]


def run(library, out, *options):
    return cli("run", library, "--out", out, *OPTIONS, *options)


def places(out, kind):
    return {path.relative_to(out / kind).as_posix() for path in (out / kind).rglob("*.npz")}


@pytest.fixture
def divided(motions, tmp_path, monkeypatch):
    """A library of eight clips and its results, where four are many."""
    monkeypatch.setattr(folder, "MANY_CLIPS", 3)
    library, out = tmp_path / "library", tmp_path / "out"
    shutil.copytree(motions, library)
    assert run(library, out)[0] == 0
    return library, out


def test_each_clip_has_its_subfolder_and_all_is_found_there_and_no_link_is_followed(
    divided, tmp_path, monkeypatch
):
    library, out = divided
    for kind in ("motions", "signals", ".w2w/features"):
        assert len(places(out, kind)) == 8
        assert all(len(name.split("/")) == 2 for name in places(out, kind))
    study = StudyResults.load(out)
    name = study.clips[0].name
    assert study.motion(name).n_frames == 150
    assert motion_file(out, name).parent.parent == out / "motions"
    assert "Nothing has changed" in run(library, out)[1]
    monkeypatch.setattr(folder, "MANY_CLIPS", 4096)  # it stays as it was begun
    assert "Nothing has changed" in run(library, out)[1]
    assert run(library, tmp_path / "flat")[0] == 0
    assert all("/" not in name for name in places(tmp_path / "flat", "motions"))
    for file in ("utility.csv", "summary.json", "clips.jsonl", "utility.npz"):
        assert (out / file).read_bytes() == (tmp_path / "flat" / file).read_bytes()
    place = motion_file(out, name).parent
    shutil.rmtree(place)
    (tmp_path / "elsewhere").mkdir()
    place.symlink_to(tmp_path / "elsewhere", target_is_directory=True)
    code, said = run(library, out)
    assert code == 2
    assert f"motions/{place.name}" in said
    assert not list((tmp_path / "elsewhere").iterdir())


def test_a_folder_begun_with_few_clips_stays_flat(motions, tmp_path, monkeypatch):
    assert run(motions, tmp_path / "out")[0] == 0
    before = places(tmp_path / "out", "motions")
    monkeypatch.setattr(folder, "MANY_CLIPS", 3)
    assert "Nothing has changed" in run(motions, tmp_path / "out")[1]
    assert places(tmp_path / "out", "motions") == before


def test_what_an_earlier_library_left_goes_and_what_is_foreign_is_refused(divided):
    library, out = divided
    gone = sorted(library.rglob("*.npz"))[0]
    gone.unlink()
    assert run(library, out)[0] == 0
    for kind in ("motions", "signals", ".w2w/features"):
        assert len(places(out, kind)) == 7
    clip = StudyResults.load(out).clips[0].name
    records = out / ".w2w" / "records.jsonl"
    lines = [line for line in records.read_text().split("\n") if f'"clip": "{clip}"' not in line]
    records.write_text("\n".join(lines))  # now none says that the clip's files are ours
    code, said = run(library, out)
    assert code == 2
    assert motion_file(out, clip).relative_to(out).as_posix() in said
