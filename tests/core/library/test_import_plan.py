# SPDX-License-Identifier: GPL-3.0-or-later
"""What an import would take, by which labels, and what it leaves out and why."""

import pytest

from w2w.core.library.import_plan import (
    AUTOMATIC,
    BY_CSV,
    BY_FILE,
    BY_FOLDER,
    LABELLED,
    LEFT_OUT,
    UNLABELLED,
    activity_of_action,
    by_activity,
    outcome_sentence,
    plan_files,
    plan_folder,
    preview,
    same_files,
    taken_before,
    without_known,
)
from w2w.core.library.library import LibraryError

TAKEN = ("Jump.bvh", "X Bot@Jump High.fbx", "walking/Strolling (1).fbx")


@pytest.fixture
def folder(tmp_path):
    """Motions in folders and beside them; one of them twice under two names."""
    files = {
        "walking/Strolling.fbx": b"stroll",
        "walking/Strolling (1).fbx": b"stroll",
        "Jump.bvh": b"jump",
        "X Bot@Jump High.fbx": b"higher",
    }
    for file, content in files.items():
        path = tmp_path / "My Clips" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return tmp_path / "My Clips"


def labels(plan):
    return {clip.file: clip.activity for clip in plan.clips}


@pytest.mark.parametrize(
    ("by", "expected"),
    [
        (AUTOMATIC, ["jump", "jump_high", "walking"]),
        (BY_FILE, ["jump", "jump_high", "strolling"]),
        (BY_FOLDER, ["my_clips", "my_clips", "walking"]),
    ],
)
def test_folder_or_file_name_labels_as_chosen_and_a_copy_is_left_out(folder, by, expected):
    plan = plan_folder(folder, by)
    assert labels(plan) == dict(zip(TAKEN, expected, strict=True))
    assert plan.left_out == (("walking/Strolling.fbx", "it is the same file as walking/Strolling (1).fbx"),)


def test_a_csv_labels_what_it_lists_and_the_rest_is_left_out_with_a_reason(folder, tmp_path):
    table = tmp_path / "mine.csv"
    table.write_text("file,activity,subject\nJump.bvh,hop,Ann\nX Bot@Jump High.fbx,,\n")
    plan = plan_folder(folder, BY_CSV, table)
    assert labels(plan) == {"Jump.bvh": "hop"}
    assert plan.clips[0].subject == "Ann"
    assert ("X Bot@Jump High.fbx", "mine.csv gives it no activity") in plan.left_out
    assert ("walking/Strolling.fbx", "mine.csv does not list it") in plan.left_out


def test_labels_csv_of_the_folder_is_taken_by_itself_and_may_be_left_aside(folder):
    (folder / "labels.csv").write_text("file,activity\nJump.bvh,hop\n")
    assert labels(plan_folder(folder)) == {"Jump.bvh": "hop"}
    assert labels(plan_folder(folder, BY_CSV)) == {"Jump.bvh": "hop"}
    assert labels(plan_folder(folder, BY_FILE))["Jump.bvh"] == "jump"


def test_single_files_are_labelled_alike(folder):
    paths = [folder / "Jump.bvh", folder / "walking/Strolling.fbx", folder / "notes.txt"]
    (folder / "notes.txt").write_text("no motion")
    plan = plan_files(paths)
    assert labels(plan) == {"Jump.bvh": "jump", "Strolling.fbx": "strolling"}
    assert [name for name, _ in plan.left_out] == ["notes.txt"]
    assert labels(plan_files(paths, BY_FOLDER)) == {"Jump.bvh": "my_clips", "Strolling.fbx": "walking"}
    (folder / "mine.csv").write_text("file,activity\nJump.bvh,hop\n")
    plan = plan_files(paths[:2], BY_CSV, folder / "mine.csv")
    assert labels(plan) == {"Jump.bvh": "hop"}
    assert plan.left_out == (("Strolling.fbx", "mine.csv gives it no activity"),)
    with pytest.raises(LibraryError, match="choose motion files"):
        plan_files([folder / "notes.txt"])
    with pytest.raises(LibraryError, match=r"gone\.csv"):
        plan_files(paths[:1], BY_CSV, folder / "gone.csv")


def test_files_taken_before_are_known_by_their_path_or_their_content(folder, tmp_path):
    (tmp_path / "elsewhere.bvh").write_bytes(b"jump")
    plan = without_known(plan_folder(folder), [tmp_path / "elsewhere.bvh", folder / "X Bot@Jump High.fbx"])
    assert set(plan.known) == {"Jump.bvh", "X Bot@Jump High.fbx"}
    assert labels(plan) == {"walking/Strolling (1).fbx": "walking"}


def test_files_of_equal_size_are_compared_and_empty_ones_are_not(tmp_path):
    for name, content in (("a", b"12"), ("b", b"21"), ("c", b"12"), ("d", b""), ("e", b"")):
        (tmp_path / name).write_bytes(content)
    assert same_files([tmp_path / name for name in "abcde"]) == {tmp_path / "c": tmp_path / "a"}


def test_clips_without_a_label_come_last(folder):
    (folder / "(2).fbx").write_bytes(b"nameless")
    activities = plan_files([folder / "(2).fbx", folder / "Jump.bvh"]).activities
    assert list(activities.items()) == [("jump", ["Jump.bvh"]), ("", ["(2).fbx"])]


@pytest.mark.parametrize(
    ("action", "activity"),
    [
        ("Walk Cycle", "walk_cycle"),
        ("Walk.003", "walk"),
        ("Rig|Sit To Stand|BaseLayer", "sit_to_stand"),
        ("mixamo.com", ""),
        ("Armature|mixamo.com|Layer0.001", ""),
        ("RigAction.001", ""),
        ("Take 001", ""),
        ("Reaction", "reaction"),
    ],
)
def test_an_action_s_name_labels_where_it_says_anything(action, activity):
    assert activity_of_action(action, "Rig") == activity


def test_files_of_kinds_that_are_not_read_are_counted(folder):
    for name in ("a.mot", "b.mot"):
        (folder / name).touch()
    unread = plan_folder(folder).unread
    assert unread.startswith("2 files of kinds that are not read: 2 .mot; mot and sto hold the angles")
    assert plan_folder(folder, BY_FILE).unread == unread


def test_files_of_one_folder_whose_names_all_differ_are_labelled_by_it(tmp_path):
    folder = tmp_path / "Walking"
    folder.mkdir()
    paths = [folder / f"{name}.bvh" for name in ("anna", "ben", "carl", "Jump", "Jump (1)")]
    for number, path in enumerate(paths):
        path.write_text(f"HIERARCHY {number}")
    assert set(labels(plan_files(paths[:3])).values()) == {"walking"}
    assert set(labels(plan_files(paths[:3], BY_FILE)).values()) == {"anna", "ben", "carl"}
    assert labels(plan_files(paths[2:])) == {"carl.bvh": "carl", "Jump.bvh": "jump", "Jump (1).bvh": "jump"}
    assert labels(plan_files(paths[:1])) == {"anna.bvh": "anna"}


def test_a_copy_of_a_known_file_was_taken_before(tmp_path):
    for name, text in (("known", "one"), ("copy", "one"), ("new", "two")):
        (tmp_path / name).write_text(text)
    files = [tmp_path / name for name in ("known", "copy", "new", "missing")]
    assert taken_before(files, [tmp_path / "known"]) == {tmp_path / "known", tmp_path / "copy"}


def test_clips_without_an_activity_come_last():
    clips = [("walk", "b"), ("", "c"), ("run", "d"), ("walk", "a")]
    assert list(by_activity(clips).items()) == [("run", ["d"]), ("walk", ["b", "a"]), ("", ["c"])]


def test_an_import_says_what_to_look_at():
    assert outcome_sentence(2, 0, 0, 0, []) == "Imported 2 motions"
    said = outcome_sentence(3, 1, 2, 1, ["walk", "run"])
    assert said.startswith("Imported 3 motions; 1 file cannot be used: the list says why; 2 left out")
    assert said.endswith("'walk' and 1 more was in the list already: one motion twice flatters a ranking")


def test_a_preview_has_unlabelled_clips_after_the_others_and_last_what_is_left_out():
    title, rows = preview({"": ["c"], "walk": ["a", "b"]}, [("d", "it is empty")])
    assert title == "3 clips, 1 activity, 1 left out"
    assert rows == [
        ("walk  (2)", "a and b", LABELLED),
        ("No activity, not ranked  (1)", "c", UNLABELLED),
        ("d", "it is empty", LEFT_OUT),
    ]
    assert preview({"walk": ["a"]}, [])[0] == "1 clip, 1 activity"
