# SPDX-License-Identifier: GPL-3.0-or-later
"""Labels chosen at import: what is taken, what is warned of, what is left out."""

from __future__ import annotations

import shutil
from pathlib import Path

import bpy
import pytest

from w2w.ui.jobs import jobs
from w2w.ui.steps.import_dialog import LONGEST, ROWS, draw_preview

from .made_study import make_study, take_through

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


@pytest.fixture
def folder(library: Path, tmp_path: Path) -> Path:
    """Motions in folders by activity, one of them twice, and a csv that labels two otherwise."""
    folder = tmp_path / "own"
    shutil.copytree(library, folder)
    shutil.copy(folder / "waving/waving 0.npz", folder / "waving/waving 9.npz")
    (folder / "mine.csv").write_text("file,activity\nwaving 1.npz,greeting\nkicking 2.npz,football\n")
    return folder


def labels() -> dict[str, str]:
    clips = bpy.context.scene.w2w.body.w2w.clips
    return {Path(clip.file).name: clip.activity for clip in clips if not clip.problem}


def test_files_are_labelled_as_chosen(folder: Path) -> None:
    body = take_through(folder, "")
    assert bpy.ops.w2w.import_labelled(directory=str(folder), labelled_by="FILE") == {"FINISHED"}
    assert labels()["waving 1.npz"] == "waving_1"
    bpy.ops.w2w.tick_clips(which="ALL")
    bpy.ops.w2w.remove_clips()
    bpy.ops.w2w.import_labelled(directory=str(folder), labelled_by="CSV", csv=str(folder / "mine.csv"))
    assert labels() == {"waving 1.npz": "greeting", "kicking 2.npz": "football"}
    reasons = {clip.problem for clip in body.w2w.clips if clip.problem}
    assert reasons == {"mine.csv does not list it"}
    assert "8 left out: the list says why" in jobs.message.text


@pytest.mark.slow
def test_a_copy_is_left_out_and_files_in_the_list_are_not_taken_again(folder: Path) -> None:
    body = take_through(folder, "")
    bpy.ops.w2w.import_labelled(directory=str(folder))
    assert [clip.problem for clip in body.w2w.clips if clip.problem] == [
        "it is the same file as waving/waving 0.npz"
    ]
    assert len(labels()) == 9
    with pytest.raises(RuntimeError, match="All of these files are in the list already"):
        bpy.ops.w2w.import_labelled(directory=str(folder / "kicking"))
    bpy.ops.w2w.import_labelled(directory=str(folder / "kicking"), again=True)
    assert len(body.w2w.clips) == 13
    assert "'kicking 0.npz' and 2 more was in the list already" in jobs.message.text


def test_the_same_file_dropped_twice_is_warned_of(folder: Path) -> None:
    take_through(folder, "")
    for _ in range(2):
        bpy.ops.w2w.import_motions(directory=str(folder / "waving"), files=[{"name": "waving 1.npz"}])
    assert "'waving 1.npz' was in the list already: one motion twice flatters" in jobs.message.text


def test_a_bad_csv_is_said(folder: Path) -> None:
    take_through(folder, "")
    with pytest.raises(RuntimeError, match=r"gone\.csv"):
        bpy.ops.w2w.import_labelled(directory=str(folder), labelled_by="CSV", csv=str(folder / "gone.csv"))


@pytest.mark.slow
def test_a_clip_without_an_activity_is_not_one(library: Path) -> None:
    body = make_study(library, "motions patches signals")
    for clip in body.w2w.clips:
        if clip.activity == "stepping":
            clip.activity = " "
    assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    assert [activity.name for activity in body.w2w.activities] == ["kicking", "waving"]
    for clip in body.w2w.clips:
        clip.activity = ""
    assert not bpy.ops.w2w.rank_patches.poll()


@pytest.mark.slow
def test_each_import_reads_the_labels_and_the_folder_anew(folder: Path) -> None:
    take_through(folder, "")
    (folder / "labels.csv").write_text("file,activity\nwaving 1.npz,greeting\n")
    bpy.ops.w2w.import_labelled(directory=str(folder))
    assert labels() == {"waving 1.npz": "greeting"}
    for text, extra in (("waving 1.npz,hailing", None), ("waving 1.npz,hailing\nnew.npz,bow", "new.npz")):
        bpy.ops.w2w.tick_clips(which="ALL")
        bpy.ops.w2w.remove_clips()
        (folder / "labels.csv").write_text(f"file,activity\n{text}\n")
        if extra:
            shutil.copy(folder / "kicking/kicking 1.npz", folder / extra)
        bpy.ops.w2w.import_labelled(directory=str(folder))
        assert labels() == dict(row.split(",") for row in text.split("\n"))


class Written:
    """A layout that keeps the texts drawn into it."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def label(self, text: str = "", **_: object) -> None:
        self.texts.append(text)

    def same(self, **_: object) -> Written:
        return self

    box = column = split = row = same


def test_the_preview_says_what_is_labelled_how_and_what_is_left_out_and_why() -> None:
    layout = Written()
    many = [f"walk {number}.fbx" for number in range(7)]
    draw_preview(
        layout, {"walking": many, "": ["x.fbx"]}, [("y.fbx", "labels.csv does not list it")], ["A note."]
    )
    assert layout.texts == [
        "8 clips, 1 activity, 1 left out",
        "walking  (7)",
        "walk 0.fbx, walk 1.fbx, walk 2.fbx and 4 more",
        "No activity, not ranked  (1)",
        "x.fbx",
        "y.fbx: labels.csv does not list it",
        "A note.",
    ]


def test_a_long_preview_has_pages_of_a_window_s_height() -> None:
    many, left_out = {f"a{number}": ["x" * 200] for number in range(30)}, [("f", "r" * 200)] * 4
    pages = []
    for page in (1, 2, 4):
        layout = Written()
        draw_preview(layout, many, left_out, (), page)
        pages.append(layout.texts[1:])
        assert max(map(len, layout.texts)) <= LONGEST
    assert [texts[0] for texts in pages[:2]] == ["a0  (1)", "a10  (1)"]
    assert [len(texts) for texts in pages] == [2 * ROWS, 2 * ROWS, 4]
    assert pages[2][0].startswith("f: rrr")


def test_a_folder_that_is_clicked_once_is_the_one_that_is_taken(folder: Path) -> None:
    bpy.ops.w2w.import_folder(directory=str(folder), dirs=[{"name": "kicking"}])
    assert {Path(clip.file).parent.name for clip in bpy.context.scene.w2w.body.w2w.clips} == {"kicking"}


@pytest.mark.slow
def test_a_frame_rate_given_at_import_goes_before_the_files_own(folder: Path) -> None:
    body = take_through(folder, "")
    bpy.ops.w2w.import_labelled(directory=str(folder), frame_rate=25.0)
    assert {(clip.rate, clip.given_rate) for clip in body.w2w.clips if not clip.problem} == {(25.0, 25.0)}
